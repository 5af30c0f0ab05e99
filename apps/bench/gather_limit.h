/// What the look-ups alone cost: the limit that the CPU kernel is held against.
#pragma once

#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Nanoseconds that one particle-sample costs when its address in the score table costs nothing:
/// the two gathers of the kernel (two rows of pairs), in the kernel's order of samples and
/// particles, on the calling thread. Addresses are those of the visible samples at the first pose,
/// shifted for every particle as the middle of the image is.
double gatherLimitNanoseconds(const LikelihoodFrame& frame, const VisibleSet& set,
                              const std::vector<Pose>& camera_poses, int repeats);

}  // namespace edge_mcl
