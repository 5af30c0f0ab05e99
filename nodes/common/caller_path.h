/// File names as the caller of a node means them.
#pragma once

#include <string>

namespace edge_mcl {

/// roslaunch starts nodes in ~/.ros. A relative file name means the folder in which the caller is,
/// which the environment variable PWD still names.
/// @return `file` when it is empty, absolute or in the folder of the process; otherwise the file in
///   the caller's folder when it exists there. @throws InputError that names both folders when the
///   file is in neither
std::string callerPath(const std::string& file);

}  // namespace edge_mcl
