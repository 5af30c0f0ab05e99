/// Check of a PLY header before assimp reads the file.
#pragma once

#include <string>

namespace edge_mcl {

/// Checks the grammar of a PLY header (G. Turk, "The PLY Polygon File Format"). The PLY reader of
/// assimp (5.2) does not check the header. If it is broken, the reader reads beyond the end of its
/// buffer.
/// @throws InputError that names the file and the faulty line.
void checkPlyHeader(const std::string& file);

}  // namespace edge_mcl
