/// Finds the view that tells two places apart.
#pragma once

#include <optional>
#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// A view in which two places differ. The robot reaches it by the same motion from both places.
struct NextView {
  Pose first = Pose::Identity();   ///< T_map_base there, if the first place is right
  Pose second = Pose::Identity();  ///< T_map_base there, if the second place is right
  /// Share of the lines in view that only one of the two places shows, 0 to 1.
  double difference = 0;

  /// A motion as a pilot understands it.
  struct Step {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< m: forward, left, up
    double turn = 0;                                  ///< about the vertical, rad; left is positive
  };
  /// The motion from a pose to `first`. "Forward" is where the first camera looks, without its
  /// tilt.
  /// @param now T_map_base of the first place. @param T_base_camera of the first camera.
  Step stepFrom(const Pose& now, const Pose& T_base_camera) const;
};

/// Compares what the cameras would see from both places after many small motions: turns by eighths,
/// and flights of up to some metres that are free of obstacles in both places. It takes the
/// shortest motion whose view differs nearly as much as the best one.
/// @param views cameras of the robot; those without an image are left out.
/// @param first, second T_map_base now.
/// @return none when no view differs.
/// @throws Error when memory runs out.
std::optional<NextView> nextView(const LocalizationMap& map, const std::vector<CameraView>& views,
                                 const Pose& first, const Pose& second);

}  // namespace edge_mcl
