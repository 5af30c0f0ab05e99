/// Defines one interface for all filters of the comparison.
#pragma once

#include <memory>

#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// Estimates the pose of a camera from moment to moment. The base of the input is the camera, so
/// T_map_base = T_map_camera. The z axis of the map points up.
class ComparedFilter {
 public:
  virtual ~ComparedFilter() = default;
  /// Starts the filter. @param start T_map_camera.
  virtual void initialize(const PoseGaussian& start) = 0;
  /// Uses the data of one moment. @param truth T_map_camera; a method may take from it only what
  /// its description says. @return T_map_camera
  virtual Pose process(const LiveInput& input, const Pose& truth) = 0;
};

/// Motion of the camera between two moments with its uncertainty. All filters get the same motion
/// and edge_mcl's model of its noise.
struct Motion {
  Pose increment = Pose::Identity();  ///< of the camera, in its own frame
  Vector6 sigma = Vector6::Zero();    ///< standard deviations, m and rad
};

/// Computes the motion between moments from the odometry.
class MotionSource {
 public:
  explicit MotionSource(const FilterParameters& params) : params_(params) {}
  /// Returns the motion since the last call; the first call returns no motion. Without odometry the
  /// increment is identity, and the standard deviations are those of a random walk
  /// (`filter.walk_*`).
  Motion next(const LiveInput& input);

 private:
  FilterParameters params_;
  std::optional<Pose> last_odometry_;
  std::optional<double> last_time_;
};

}  // namespace edge_mcl
