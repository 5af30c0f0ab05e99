/// A pose of the robot from two points that the user showed on the model.
#pragma once

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Above the point where the mouse was pressed, as high above it as people and robots look about,
/// heading to where it was let go. Pressed and let go at one place: the heading stays.
/// @param moment for what is kept. The result is uncertain by half a metre and 15 degrees.
PoseGaussian poseFromPick(const ViewMoment& moment, const Eigen::Vector3d& pressed,
                          const Eigen::Vector3d& released);

}  // namespace edge_mcl
