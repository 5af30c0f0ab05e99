#include "edge_mcl/viewer/drawing/view_parameters.h"

#include <cmath>

#include "edge_mcl/core/base/parameter_struct.h"

namespace edge_mcl {

std::vector<std::string> ViewParameters::faults() const {
  std::vector<std::string> list;
  const auto require = [&](bool good, const char* name, const char* rule) {
    if (!good) list.push_back(std::string("parameter '") + name + "' must be " + rule);
  };
  // Videos have even sizes.
  require(width >= 640 && width <= 7680 && width % 2 == 0, "width", "even, 640 to 7680");
  require(height >= 400 && height <= 4320 && height % 2 == 0, "height", "even, 400 to 4320");
  require(model_style == "solid" || model_style == "ghost" || model_style == "wireframe",
          "model_style", "solid, ghost or wireframe");
  require(std::abs(azimuth) <= 360, "azimuth", "-360 to 360");
  require(elevation >= -90 && elevation <= 90, "elevation", "-90 to 90");
  require(zoom >= 0.05 && zoom <= 50, "zoom", "0.05 to 50");
  require(std::abs(cut_above) <= 1e6, "cut_above", "within 1e6");
  require(max_particles >= 1 && max_particles <= 1000000, "max_particles", "1 to 1000000");
  require(strip_seconds >= 1 && strip_seconds <= 3600, "strip_seconds", "1 to 3600");
  return list;
}

void ViewParameters::validate() const { throwFaults(faults()); }

void ViewParameters::set(const std::string& name, const std::string& value) {
  setParameter(name, value, this);
}

}  // namespace edge_mcl
