#include "edge_mcl/detector/detector_parameters.h"

#include <cmath>

#include "edge_mcl/core/base/parameter_struct.h"

namespace edge_mcl {

std::vector<std::string> DetectorParameters::faults() const {
  std::vector<std::string> list;
  const auto require = [&](bool good, const char* name, const char* rule) {
    if (!good) list.push_back(std::string("parameter '") + name + "' must be " + rule);
  };
  require(score_threshold >= 0 && score_threshold < 1, "score_threshold", "0 up to 1");
  require(nms_threshold > 0 && nms_threshold <= 1, "nms_threshold", "in (0, 1]");
  require(min_area >= 0 && min_area < 1, "min_area", "0 up to 1");
  require(dilation >= 0 && dilation <= 100, "dilation", "0 to 100");
  require(dilation_growth >= 0 && dilation_growth <= 100, "dilation_growth", "0 to 100");
  require(std::isfinite(half_life) && half_life > 0, "half_life", "positive");
  require(min_confidence >= 0 && min_confidence < 1, "min_confidence", "0 up to 1");
  require(max_misses >= 1 && max_misses <= 1000, "max_misses", "1 to 1000");
  require(std::isfinite(memory) && memory >= 0, "memory", "zero or more");
  require(points >= 4 && points <= 1000, "points", "4 to 1000");
  require(threads >= 0 && threads <= 1024, "threads", "0 to 1024");
  return list;
}

void DetectorParameters::validate() const { throwFaults(faults()); }

void DetectorParameters::set(const std::string& name, const std::string& value) {
  setParameter(name, value, this);
}

}  // namespace edge_mcl
