/// From the types of core/ to those of the device.
#pragma once

#include <vector>

#include "edge_mcl/core/likelihood_backend.h"
#include "edge_mcl/gpu/particle_score.h"

namespace edge_mcl::gpu {

Camera cameraOf(const CameraModel& camera);
Table tableOf(const ScoreTable& table);
Rule ruleOf(const LikelihoodFrame& frame);
Combination combinationOf(const LikelihoodParameters& params);
/// @param cell number of the visibility cell on the device.
Particle particleOf(const edge_mcl::Pose& T_map_camera, uint32_t cell);

/// A visible set as the device stores it.
struct CellData {
  Cell cell;
  std::vector<Segment> segments;
  std::vector<uint32_t> group_ends;
};
/// @param origin near the cameras that use the cell, map, metres.
CellData cellOf(const VisibleSet& set, const Eigen::Vector3d& origin);

}  // namespace edge_mcl::gpu
