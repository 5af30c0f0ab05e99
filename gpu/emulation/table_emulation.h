/// Score tables on the host, by the bodies of the device's kernels.
#pragma once

#include <vector>

#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

/// From a picture.
std::vector<Quad> emulateTable(const TableRecipe& recipe, const PictureData& picture);
/// From a table of the host. @param pairs ScoreTable::pairs.
std::vector<Quad> emulateTable(const Table& table, const uint16_t* pairs);

}  // namespace edge_mcl::gpu
