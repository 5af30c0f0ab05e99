/// The CUDA kernel's work on the host, lane by lane: for tests where there is no device.
#pragma once

#include <vector>

#include "edge_mcl/gpu/workload/workload.h"

namespace edge_mcl::gpu {

/// @param quads the workload's table, see emulateTable.
/// @return the same bits as the kernel with that many warps per particle, where the device's
/// division, root and arc tangent round like the host's.
std::vector<Result> emulate(const Workload& workload, const std::vector<Quad>& quads, int warps);

}  // namespace edge_mcl::gpu
