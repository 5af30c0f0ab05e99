#include "edge_mcl/viewer/drawing/view_parameters.h"

#include "edge_mcl/core/base/parameter_struct.h"

namespace edge_mcl {

std::vector<std::string> ViewParameters::faults() const {
  // Video codecs want even sizes.
  if (width % 2 == 0 && height % 2 == 0) return {};
  return {"width and height must be even numbers"};
}

void ViewParameters::validate() const { throwFaults(parameterFaults(*this)); }

void ViewParameters::set(const std::string& name, const std::string& value) {
  setParameter(name, value, this);
}

}  // namespace edge_mcl
