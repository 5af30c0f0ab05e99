#include "edge_mcl/core/base/yaml_file.h"

#include <filesystem>
#include <fstream>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

YAML::Node loadYamlFile(const std::string& file) {
  // A folder can be opened, but not read.
  if (std::filesystem::is_directory(file) || !std::ifstream(file))
    throw InputError(file + ": cannot be read");
  try {
    return YAML::LoadFile(file);
  } catch (const YAML::Exception& e) {
    throw InputError(file + ": not a YAML file: " + e.what());
  }
}

}  // namespace edge_mcl
