/// A workload file's content from a map, an image and poses.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"
#include "edge_mcl/gpu/workload/workload.h"

namespace edge_mcl::gpu {

/// @param reference results of the CPU backend, one per pose. @param picture what the frame's table
/// was made of, so that a device can make it, too.
Workload makeWorkload(const std::string& name, const Visibility& visibility,
                      const LikelihoodFrame& frame, const std::vector<edge_mcl::Pose>& camera_poses,
                      const std::vector<PoseScore>& reference, const Picture* picture = nullptr);

}  // namespace edge_mcl::gpu
