#include "edge_mcl/localization/filter/odometry_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/angles.h"

namespace edge_mcl {

namespace {

// Standard deviations before the first image. Wheels and visual odometry are seldom off by more
// than twice these values.
constexpr double kScale = 0.05, kTurnRate = 1 * kDegree;  // 1, rad/s
// How far they drift in a second: an error is learnt anew within some minutes.
constexpr double kScaleDrift = 0.002, kTurnDrift = 0.03 * kDegree;  // 1/sqrt(s), rad/s/sqrt(s)
// Limits of what is believed.
constexpr double kLargestScale = 0.3, kLargestTurn = 15 * kDegree;  // 1, rad/s
constexpr double kSmallestFactor = 1, kLargestFactor = 5;
// Weight of a step in the factor. It falls over about twenty steps, and rises in a few, since a
// filter that trusts a slipping wheel loses the track.
constexpr double kDown = 0.05, kUp = 0.15;
// A single slip counts at most as much as this normalised squared innovation.
constexpr double kLargestSurprise = 6;

}  // namespace

Eigen::Matrix4d OdometryCalibration::startCovariance() {
  Eigen::Vector4d sigma;
  sigma << kScale, kTurnRate, kTurnRate, kTurnRate;
  return sigma.cwiseAbs2().asDiagonal();
}

double OdometryCalibration::noiseFactor() const { return std::exp(log_factor_); }

Pose OdometryCalibration::corrected(const Pose& increment, double dt) const {
  Pose result = increment;
  result.translation() *= 1 + state_[0];
  result.linear() = result.linear() * expSo3(state_.tail<3>() * dt);
  return result;
}

void OdometryCalibration::learn(const Pose& increment, double dt, const Twist& innovation,
                                const Vector6& noise, const Matrix6& rest) {
  if (!innovation.allFinite() || !(dt > 0)) return;
  const double factor = noiseFactor();
  Matrix6 measured = rest;
  measured.diagonal() += factor * factor * noise;
  // The innovation is that of corrected odometry, so the state's mean is no part of it.
  Eigen::Matrix<double, 6, 4> by_state = Eigen::Matrix<double, 6, 4>::Zero();
  // The estimated motion, not the reported one: the noise of the reported motion would look like a
  // scale below 1.
  by_state.topLeftCorner<3, 1>() =
      increment.linear().transpose() * increment.translation() + innovation.head<3>();
  by_state.bottomRightCorner<3, 3>() = dt * Eigen::Matrix3d::Identity();
  const Eigen::Vector4d drift(kScaleDrift, kTurnDrift, kTurnDrift, kTurnDrift);
  covariance_ += Eigen::Matrix4d((dt * drift.cwiseAbs2()).asDiagonal());
  const Matrix6 total = by_state * covariance_ * by_state.transpose() + measured;
  const Eigen::LLT<Matrix6> cholesky(total);
  if (cholesky.info() != Eigen::Success) return;
  const Twist weighted = cholesky.solve(innovation);
  const double surprise = innovation.dot(weighted) / 6;
  const double share = factor * factor * cholesky.solve(Matrix6(noise.asDiagonal())).trace() / 6;
  log_factor_ += (surprise > 1 ? kUp : kDown) * share * (std::min(surprise, kLargestSurprise) - 1);
  log_factor_ = std::clamp(log_factor_, std::log(kSmallestFactor), std::log(kLargestFactor));
  // A step that is an outlier tells nothing about slow errors.
  if (surprise > kLargestSurprise) return;
  const Eigen::Matrix<double, 4, 6> gain = cholesky.solve(by_state * covariance_).transpose();
  state_ += gain * innovation;
  covariance_ -= gain * by_state * covariance_;
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  state_[0] = std::clamp(state_[0], -kLargestScale, kLargestScale);
  const double turn = state_.tail<3>().norm();
  if (turn > kLargestTurn) state_.tail<3>() *= kLargestTurn / turn;
}

}  // namespace edge_mcl
