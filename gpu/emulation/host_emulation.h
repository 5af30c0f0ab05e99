/// Does the work of the CUDA kernel on the host, lane by lane, for tests without a device.
#pragma once

#include <vector>

#include "edge_mcl/gpu/workload/workload.h"

namespace edge_mcl::gpu {

/// Scores all particles of a workload. @param quads table of the workload, see emulateTable().
/// @param warps number of warps per particle: 1 or kParts. @return one result for every particle,
/// with the same bits as the kernel, if the device rounds division, root and arc tangent like the
/// host.
std::vector<Result> emulate(const Workload& workload, const std::vector<Quad>& quads, int warps);

}  // namespace edge_mcl::gpu
