/// The network that ships with the package.
#pragma once

#include <string>

namespace edge_mcl {

/// Its description. Looked for in $EDGE_MCL_MODELS, where the package is installed, and in the
/// source tree. @throws InputError naming these places when it is in none.
std::string defaultModelFile();

}  // namespace edge_mcl
