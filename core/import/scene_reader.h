/// Reads a model file with assimp.
#pragma once

#include <string>

#include "edge_mcl/core/import/raw_model.h"

namespace edge_mcl {

/// Reads a model file of any format that assimp knows. Vertices keep the axes of the file. This
/// function can crash, hang or exhaust the memory on a broken file, so importModel() calls it in a
/// process of its own.
/// @throws InputError that names the file when it cannot be read.
RawModel readScene(const std::string& file);

}  // namespace edge_mcl
