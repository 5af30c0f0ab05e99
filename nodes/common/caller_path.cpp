#include "edge_mcl/nodes/common/caller_path.h"

#include <cstdlib>
#include <filesystem>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

std::string callerPath(const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path path(file);
  std::error_code none;
  if (file.empty() || path.is_absolute()) return file;
  const char* caller = std::getenv("PWD");
  const fs::path of_caller = caller == nullptr ? fs::path() : fs::path(caller) / path;
  // The caller's folder comes first, since ~/.ros may hold an old file of the same name.
  if (caller != nullptr && fs::exists(of_caller, none)) return of_caller.string();
  if (fs::exists(path, none)) return file;
  // The file of a camera may name one of several: chain.yaml:cam1.
  if (const auto colon = file.rfind(':'); colon != std::string::npos && colon > 0)
    return callerPath(file.substr(0, colon)) + file.substr(colon);
  const fs::path here = fs::current_path(none);
  std::string where = here.string();
  if (caller != nullptr && here != fs::path(caller)) where = std::string(caller) + " or " + where;
  throw InputError(file + ": there is no such file in " + where +
                   "; nodes start in ~/.ros, so give an absolute name");
}

}  // namespace edge_mcl
