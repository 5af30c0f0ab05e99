/// Poses that a tool for robots on the ground has set, e.g. RViz's "2D Pose Estimate".
#pragma once

#include <geometry_msgs/PoseWithCovariance.h>

#include <optional>
#include <string>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/tilt_correction.h"

namespace edge_mcl {

/// Whether a pose tells position and heading in the plane only: height, roll and pitch are zero and
/// have no variance, but the position has one.
bool isPlanar(const geometry_msgs::PoseWithCovariance& message);

/// What a planar pose leaves open, and where it comes from instead.
struct PlanarContext {
  std::optional<PoseGaussian> last;  ///< T_map_base that was tracked before; gives height and tilt
  std::optional<UpReading> up;       ///< roll and pitch of an IMU; preferred to those of `last`
  bool is_camera_base = false;       ///< the base has the axes of an optical frame
};

/// Completes a planar pose. Without a last pose the height is that of the free space at this place,
/// with a standard deviation that covers it.
/// @return T_map_base with the covariance of the message, at least 0.5 m and 15 degrees. The pose
///   is to be searched for around it.
/// @throws InputError when the pose is wrong, see fromMessage()
PoseGaussian completePlanar(const geometry_msgs::PoseWithCovariance& message,
                            const LocalizationMap& map, const PlanarContext& context);

/// A hint for a person who has set a position (m, map) beside the model, seen from above. Such a
/// position may be right outdoors. Mostly the fixed frame or the unit of the model is wrong.
/// @return one line that names where the model lies; empty: the position is over or in the model
std::string hintBeside(const MeshModel& mesh, const Eigen::Vector3d& position);

}  // namespace edge_mcl
