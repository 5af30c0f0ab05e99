/// Holds the constants and look-up tables with which a device makes score tables from pictures.
#pragma once

#include <vector>

#include "edge_mcl/gpu/math/code_math.h"

namespace edge_mcl::gpu {

/// Recipe for pictures of one size, in host memory. It must not change, because engines upload it
/// only once.
struct TableRecipe {
  PictureWork work{};                    ///< sizes and numbers, without buffers
  std::vector<DirectionBin> directions;  ///< PictureWork::direction
  std::vector<int32_t> shifts;           ///< PictureWork::shift
  std::vector<uint8_t> level_codes;      ///< PictureWork::level_codes
  std::vector<float> level_borders;      ///< PictureWork::level_borders
};

/// A picture in host memory. It has the size of the recipe.
struct PictureData {
  const uint8_t* grey;
  size_t stride;          ///< bytes from row to row
  const uint8_t* ignore;  ///< non-zero: ignored; null without a mask
  size_t ignore_stride;   ///< bytes from row to row
};

/// Numbers of elements of the buffers of PictureWork.
inline size_t pixelsOf(const PictureWork& w) {
  return static_cast<size_t>(w.width) * static_cast<size_t>(w.height);
}
inline size_t cellsOf(const PictureWork& w) {
  return static_cast<size_t>(w.cell_columns) * static_cast<size_t>(w.cell_rows);
}
inline size_t sampledOf(const PictureWork& w) {
  return static_cast<size_t>(sampledColumns(w)) * static_cast<size_t>(sampledRows(w));
}
inline size_t quadsOf(const PictureWork& w) { return static_cast<size_t>(w.bins) * pixelsOf(w); }
inline size_t quadsOf(const Table& t) {
  return static_cast<size_t>(t.bins) * static_cast<size_t>(t.width) * static_cast<size_t>(t.height);
}

}  // namespace edge_mcl::gpu
