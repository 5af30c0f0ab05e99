/// Finds the network that ships with the package.
#pragma once

#include <string>

namespace edge_mcl {

/// Returns the path of the description indoor.yaml. Searches the folder $EDGE_MCL_MODELS, then the
/// source tree, then the installation. @throws InputError with these folders when the file is in
/// none of them.
std::string defaultModelFile();

}  // namespace edge_mcl
