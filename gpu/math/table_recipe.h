/// What turns pictures into score tables on a device: constants and look-up tables, on the host.
#pragma once

#include <vector>

#include "edge_mcl/gpu/math/code_math.h"

namespace edge_mcl::gpu {

/// For pictures of one size. Immutable once made; engines keep what they have uploaded of it.
struct TableRecipe {
  PictureWork work{};  ///< sizes and numbers; no buffers
  std::vector<DirectionBin> directions;
  std::vector<int32_t> shifts;
  std::vector<uint8_t> level_codes;
  std::vector<float> level_borders;
};

/// A picture on the host, width x height of the recipe.
struct PictureData {
  const uint8_t* grey;
  size_t stride;          ///< bytes between rows
  const uint8_t* ignore;  ///< non-zero: ignored; null without
  size_t ignore_stride;
};

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
