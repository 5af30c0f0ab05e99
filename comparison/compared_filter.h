/// The filters that are compared, behind one interface.
#pragma once

#include <memory>

#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// Follows a camera from moment to moment. The base of the input is the camera, T_map_base =
/// T_map_camera; the map's z axis points up.
class ComparedFilter {
 public:
  virtual ~ComparedFilter() = default;
  virtual void initialize(const PoseGaussian& start) = 0;
  /// @param truth T_map_camera; only what a method is said to be given may be taken from it.
  /// @return T_map_camera
  virtual Pose process(const LiveInput& input, const Pose& truth) = 0;
};

/// Standard deviations of what the odometry says of the motion between two moments, as all filters
/// are told: edge_mcl's own motion model.
struct Motion {
  Pose increment = Pose::Identity();  ///< of the camera, in its own frame
  Twist sigma = Twist::Zero();        ///< m, rad
};

/// Keeps the last odometry.
class MotionSource {
 public:
  explicit MotionSource(const FilterParameters& params) : params_(params) {}
  /// Since the last call; nothing at the first. Without odometry the camera is taken to stand
  /// still, and the spread is that of a walk.
  Motion next(const LiveInput& input);

 private:
  FilterParameters params_;
  std::optional<Pose> last_odometry_;
  std::optional<double> last_time_;
};

}  // namespace edge_mcl
