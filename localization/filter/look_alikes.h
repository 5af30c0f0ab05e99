/// Poses from which the model looks much the same: one step further on a stair, one shelf aside.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// Shifts that bring many of the lines in view onto others that are parallel to them, in both
/// directions, most lines first. They are perpendicular to the lines, so a shelf repeats itself
/// upwards and a stair along its slope.
/// @param T_map_camera of a view with an image
/// @return map axes, metres
std::vector<Eigen::Vector3d> repeatsInView(const LocalizationMap& map, const CameraView& view,
                                           const Pose& T_map_camera);

/// A pose that looks like another one.
struct LookAlike {
  Pose pose;             ///< T_map_base
  double advantage = 0;  ///< its log-likelihood minus that of the other pose, nats
};

/// The best pose that is a repeat away, after refinement, and looks in the same direction. @param
/// pose T_map_base
/// @return none: nothing repeats itself in view, or every start falls back to the pose
std::optional<LookAlike> bestLookAlike(const LocalizationMap& map,
                                       const std::vector<CameraView>& views, const Pose& pose);

}  // namespace edge_mcl
