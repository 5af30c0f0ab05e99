/// Makes a pose of the robot from two points that the user clicked on the model.
#pragma once

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Returns a pose (T_map_base) 1.2 m above the point where the mouse button was pressed. The camera
/// heads to the point where the button was released. When the points are less than 0.15 m apart on
/// the ground, the heading stays. The standard deviations are 0.5 m and 15 degrees per axis.
/// @param moment gives the present attitude, which is kept apart from the heading.
/// @param pressed, released map, m.
PoseGaussian poseFromPick(const ViewMoment& moment, const Eigen::Vector3d& pressed,
                          const Eigen::Vector3d& released);

}  // namespace edge_mcl
