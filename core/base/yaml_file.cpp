#include "edge_mcl/core/base/yaml_file.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

YAML::Node loadYamlFile(const std::string& file) {
  // A folder can be opened, but not read.
  std::ifstream stream(file);
  if (std::filesystem::is_directory(file) || !stream) throw InputError(file + ": cannot be read");
  std::string text((std::istreambuf_iterator<char>(stream)), {});
  // OpenCV's first line "%YAML:1.0" is no directive of YAML.
  if (text.rfind("%YAML:", 0) == 0) text.erase(0, text.find('\n'));
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw InputError(file + ": not a YAML file: " + e.what());
  }
}

}  // namespace edge_mcl
