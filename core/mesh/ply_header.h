/// A look at a PLY file before assimp reads it.
#pragma once

#include <string>

namespace edge_mcl {

/// assimp's PLY reader (5.2) takes a header as it comes and, where it is broken, reads beyond the
/// end of its buffer. This checks the header's grammar (G. Turk, "The PLY Polygon File Format").
/// @throws InputError naming the file and the faulty line.
void checkPlyHeader(const std::string& file);

}  // namespace edge_mcl
