/// Reading of YAML files. Internal: needs yaml-cpp.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

namespace edge_mcl {

/// Reads a YAML file. @throws InputError when the file cannot be read or is not YAML.
YAML::Node loadYamlFile(const std::string& file);

}  // namespace edge_mcl
