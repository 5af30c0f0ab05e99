#include "edge_mcl/detector/detector_parameters.h"

#include "edge_mcl/core/base/parameter_struct.h"

namespace edge_mcl {

void DetectorParameters::validate() const { throwFaults(parameterFaults(*this)); }

void DetectorParameters::set(const std::string& name, const std::string& value) {
  setParameter(name, value, this);
}

}  // namespace edge_mcl
