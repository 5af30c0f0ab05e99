/// Packs the visible samples of a cell in the layout of the device.
#pragma once

#include <vector>

#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/gpu/math/particle_score.h"

namespace edge_mcl::gpu {

/// A cell with its chunks and samples. Chunk numbers begin at 0.
struct CellData {
  Cell cell{};
  std::vector<Chunk> chunks;
  std::vector<Sample> samples;  ///< kLanes for every chunk
};

/// Packs the visible samples that thinning leaves. Groups that lie in similar directions are side
/// by side, so that all samples of a chunk are often out of view together. The groups are
/// distributed evenly over the parts.
/// @param origin a point near the cameras that use the cell, map, m. @param thinning see
/// LikelihoodFrame::thinning.
CellData packCell(const VisibleSet& set, const Eigen::Vector3d& origin, uint32_t thinning);

}  // namespace edge_mcl::gpu
