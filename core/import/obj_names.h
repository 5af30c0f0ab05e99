/// Names of the objects of an OBJ file.
#pragma once

#include <string>

namespace edge_mcl {

/// Joins the words of the names after `o` by underscores. assimp ends a name at its first space, so
/// that "Basic Wall 200" and "Basic Wall 300" would be one object.
/// @return whether a name was changed.
bool joinObjectNames(std::string* text);

}  // namespace edge_mcl
