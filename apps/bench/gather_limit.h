/// Times the look-ups in the score table alone. Their time is the limit with which the CPU kernel
/// is compared.
#pragma once

#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Time for one sample of one particle, ns, when its address in the score table costs nothing. Only
/// the two gathers of the kernel (two rows of pairs) are done, in the kernel's order of samples and
/// particles, on the calling thread. The addresses are those of the visible samples at the first
/// pose. For every other particle they are shifted by the motion of the middle of the image.
/// @param camera_poses T_map_camera.
/// @param repeats number of measurements, whose median is returned.
/// @return 0 when no sample is in the image or the image is too small
double gatherLimitNanoseconds(const LikelihoodFrame& frame, const VisibleSet& set,
                              const std::vector<Pose>& camera_poses, int repeats);

}  // namespace edge_mcl
