/// Visible samples as the device stores them.
#pragma once

#include <vector>

#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/gpu/math/particle_score.h"

namespace edge_mcl::gpu {

struct CellData {
  Cell cell{};
  std::vector<Chunk> chunks;
  std::vector<Sample> samples;  ///< kLanes for every chunk
};

/// Samples that thinning leaves, packed without gaps. Lines that are seen in similar directions lie
/// side by side, so that a chunk out of view is often all out of view; they are dealt out to the
/// parts evenly.
/// @param origin near the cameras that use the cell, map, metres.
CellData packCell(const VisibleSet& set, const Eigen::Vector3d& origin, uint32_t thinning);

}  // namespace edge_mcl::gpu
