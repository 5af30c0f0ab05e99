/// The CUDA kernel's work on the host, lane by lane: for tests where there is no device.
#pragma once

#include <vector>

#include "workload.h"

namespace edge_mcl::gpu {

/// The same bits as the kernel with that many teams per particle, where the device's division, root
/// and arc tangent round like the host's.
std::vector<Result> emulate(const Workload& workload, int teams);

}  // namespace edge_mcl::gpu
