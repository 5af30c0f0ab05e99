/// Parameters from a node's private namespace.
#pragma once

#include <ros/node_handle.h>

#include <map>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameter_struct.h"

namespace edge_mcl {

/// All parameters of a private namespace, as text. The elements of a list are separated by commas.
/// Parameters that only have a meaning elsewhere are left out with a warning.
std::map<std::string, std::string> readPrivateParameters(const ros::NodeHandle& private_nh);

/// True for names that other libraries (image_transport, diagnostics) read from the same namespace.
bool isForeignParameter(const std::string& name);

/// Reads what is set into a parameter struct (see parameter_struct.h).
/// @throws ParameterError that lists every unknown name with the nearest known one, every value of
/// the wrong type and every fault
template <class Struct>
Struct readParameterStruct(const ros::NodeHandle& private_nh) {
  Struct params;
  std::vector<std::string> faults;
  for (const auto& [name, value] : readPrivateParameters(private_nh)) {
    const std::optional<std::string> fault = trySetParameter(name, value, &params);
    if (!fault && isForeignParameter(name)) continue;
    if (!fault)
      faults.push_back(unknownParameter(name, parameterNames(params), "~"));
    else if (!fault->empty())
      faults.push_back(*fault);
  }
  for (std::string& fault : parameterFaults(params)) faults.push_back(std::move(fault));
  throwFaults(faults);
  return params;
}

}  // namespace edge_mcl
