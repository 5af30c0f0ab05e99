/// Learns from trusted poses what is wrong with the odometry.
#pragma once

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Scale of the translation, rate of a constant turn, and a factor on the noise of odometry.
///
/// A Kalman filter estimates scale and turn rate from innovations. An innovation is the motion from
/// the pose that odometry predicts to the pose that the images give. Both errors change slowly (a
/// random walk), so old images are forgotten. The factor follows the mean of the normalised squared
/// innovations (Y. Bar-Shalom, X. Li, T. Kirubarajan, "Estimation with applications to tracking and
/// navigation", 2001, section 5.4).
class OdometryCalibration {
 public:
  /// The increment without the known errors. @param dt its duration, s
  Pose corrected(const Pose& increment, double dt) const;
  /// Learns from one step.
  /// @param increment sum of the increments since the last image, as odometry reported them
  /// @param dt duration of the step, s
  /// @param innovation from the predicted pose to the new estimate, base frame
  /// @param noise variance of the step's odometry noise, without the factor
  /// @param rest covariance of the innovation without odometry noise
  void learn(const Pose& increment, double dt, const Twist& innovation, const Vector6& noise,
             const Matrix6& rest);

  /// Relative error of the distances that odometry reports; 0.1: true distances are 10 % longer.
  double scaleError() const { return state_[0]; }
  /// Turn that odometry does not report, base frame, rad/s.
  Eigen::Vector3d turnRate() const { return state_.tail<3>(); }
  /// Factor on the standard deviations of the odometry noise.
  double noiseFactor() const;

 private:
  static Eigen::Matrix4d startCovariance();
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance_ = startCovariance();
  double log_factor_ = 0;
};

}  // namespace edge_mcl
