/// Standard deviations of a motion, and a pose after an uncertain motion.
#pragma once

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Standard deviations of an odometry increment, per axis: metres, radians. The variance is a part
/// in proportion to the time and a part in proportion to the distance or the angle. So it is the
/// same for one long step as for many short ones (S. Thrun, W. Burgard, D. Fox, "Probabilistic
/// Robotics", 2005, section 5.4).
/// @param increment motion of the base. @param dt duration of the motion, seconds.
inline Vector6 odometryNoise(const FilterParameters& p, const Pose& increment, double dt) {
  // The parameters hold for a step of kReferenceTime seconds.
  constexpr double kReferenceTime = 0.1;
  const double root = std::sqrt(dt / kReferenceTime);
  Vector6 sigma;
  sigma.head<3>().setConstant(
      std::hypot(p.odometry_noise_position * root,
                 p.odometry_noise_per_metre * std::sqrt(increment.translation().norm())));
  sigma.tail<3>().setConstant(
      std::hypot(p.odometry_noise_angle_deg * kDegree * root,
                 p.odometry_noise_per_radian * std::sqrt(logSo3(increment.linear()).norm())));
  return sigma;
}

/// Standard deviations of a motion that the constant-velocity model predicts, per axis: metres,
/// radians. They have a part that grows with the root of the time and a part from an unknown
/// acceleration. @param dt duration of the motion, seconds.
inline Vector6 walkNoise(const FilterParameters& p, double dt) {
  // After kLongest the robot may be anywhere in a building. After a clock that jumped by a day it
  // would be on another planet.
  constexpr double kLongest = 10;
  const double time = std::min(dt, kLongest);
  const double root = std::sqrt(time), half_square = time * time / 2;
  Vector6 sigma;
  sigma.head<3>().setConstant(p.walk_position_rate * root + p.walk_acceleration * half_square);
  sigma.tail<3>().setConstant(
      kDegree * (p.walk_angle_rate_deg * root + p.walk_angular_acceleration_deg * half_square));
  return sigma;
}

/// A pose after an uncertain motion: the mean is composed with the step, and the covariance is
/// turned into the new axes and grows by the noise.
/// @param step motion in the axes of the pose. @param sigma standard deviations of the step, per
/// axis after the step: metres, radians.
inline PoseGaussian moved(const PoseGaussian& pose, const Pose& step, const Vector6& sigma) {
  const Matrix6 to_new_axes = adjoint(step.inverse());
  PoseGaussian result;
  result.mean = normalized(pose.mean * step);
  result.covariance = to_new_axes * pose.covariance * to_new_axes.transpose();
  result.covariance.diagonal() += sigma.cwiseAbs2();
  return result;
}

}  // namespace edge_mcl
