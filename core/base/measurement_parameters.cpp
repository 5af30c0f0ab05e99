#include "edge_mcl/core/base/measurement_parameters.h"

#include <cmath>
#include <sstream>

namespace edge_mcl {

std::optional<std::array<double, 3>> MapParameters::givenOrigin() const {
  std::array<double, 3> values{};
  std::istringstream in(origin);
  in.imbue(std::locale::classic());
  char comma = ',';
  for (size_t k = 0; k < values.size(); ++k)
    if ((k > 0 && (!(in >> comma) || comma != ',')) || !(in >> values[k]) ||
        !std::isfinite(values[k]))
      return std::nullopt;
  if (in >> comma) return std::nullopt;  // something follows
  return values;
}

std::vector<std::string> MapParameters::faults() const {
  if (origin == "auto" || givenOrigin()) return {};
  return {"origin = " + origin + " must be auto or three numbers X,Y,Z"};
}

}  // namespace edge_mcl
