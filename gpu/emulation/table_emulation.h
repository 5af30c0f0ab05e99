/// Makes score tables on the host with the bodies of the device's kernels.
#pragma once

#include <vector>

#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

/// Makes the table of a picture. @return elements (bin, y, x), row-major.
std::vector<Quad> emulateTable(const TableRecipe& recipe, const PictureData& picture);
/// Converts a table of the host. @param pairs ScoreTable::pairs. @return as above.
std::vector<Quad> emulateTable(const Table& table, const uint16_t* pairs);

}  // namespace edge_mcl::gpu
