/// Makes the content of a workload file from a map, an image and poses.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"
#include "edge_mcl/gpu/workload/workload.h"

namespace edge_mcl::gpu {

/// Makes a workload. @param camera_poses T_map_camera. @param reference results of the CPU backend,
/// one per pose. @param picture image of the frame's table, so that a device can make the table,
/// too; null: the workload has only the table.
Workload makeWorkload(const std::string& name, const Visibility& visibility,
                      const LikelihoodFrame& frame, const std::vector<edge_mcl::Pose>& camera_poses,
                      const std::vector<PoseScore>& reference, const Picture* picture = nullptr);

}  // namespace edge_mcl::gpu
