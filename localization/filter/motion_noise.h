/// How much a motion is uncertain.
#pragma once

#include <cmath>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Standard deviation per axis of an odometry increment over dt seconds: metres, radians.
inline Twist odometryNoise(const FilterParameters& p, const Pose& increment, double dt) {
  constexpr double kReferenceTime = 0.1, kDegree = M_PI / 180;
  const double root = std::sqrt(dt / kReferenceTime);
  Twist sigma;
  sigma.head<3>().setConstant(p.odometry_noise_position * root +
                              p.odometry_noise_per_metre * increment.translation().norm());
  sigma.tail<3>().setConstant(p.odometry_noise_angle_deg * kDegree * root +
                              p.odometry_noise_per_radian * logSo3(increment.linear()).norm());
  return sigma;
}

/// The same for the constant-velocity model.
inline Twist walkNoise(const FilterParameters& p, double dt) {
  constexpr double kDegree = M_PI / 180;
  const double root = std::sqrt(dt), half_square = dt * dt / 2;
  Twist sigma;
  sigma.head<3>().setConstant(p.walk_position_rate * root + p.walk_acceleration * half_square);
  sigma.tail<3>().setConstant(
      kDegree * (p.walk_angle_rate_deg * root + p.walk_angular_acceleration_deg * half_square));
  return sigma;
}

/// A pose after a motion of these standard deviations.
inline PoseGaussian moved(const PoseGaussian& pose, const Pose& step, const Twist& sigma) {
  const Matrix6 to_new_axes = adjoint(step.inverse());
  PoseGaussian result;
  result.mean = normalized(pose.mean * step);
  result.covariance = to_new_axes * pose.covariance * to_new_axes.transpose();
  result.covariance.diagonal() += sigma.cwiseAbs2();
  return result;
}

}  // namespace edge_mcl
