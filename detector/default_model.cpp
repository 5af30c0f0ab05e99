#include "edge_mcl/detector/default_model.h"

#include <cstdlib>
#include <filesystem>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

std::string defaultModelFile() {
  std::string looked;
  const char* chosen = std::getenv("EDGE_MCL_MODELS");
  for (const char* directory : {chosen, EDGE_MCL_SOURCE_MODELS, EDGE_MCL_INSTALLED_MODELS}) {
    if (!directory) continue;
    const std::filesystem::path file = std::filesystem::path(directory) / "indoor.yaml";
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return file.string();
    looked += (looked.empty() ? "" : ", ") + std::string(directory);
  }
  throw InputError("the default model indoor.yaml is in none of: " + looked);
}

}  // namespace edge_mcl
