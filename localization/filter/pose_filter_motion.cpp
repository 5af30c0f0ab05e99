// Motion of the particles and of the estimate, and the velocity that is learnt.
#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/mode_proposal.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/filter/pose_filter.h"

namespace edge_mcl {

namespace {

double square(double x) { return x * x; }

/// Standard deviations of a velocity that the motion of several images has told.
constexpr double kKnownSpeed = 0.2, kKnownTurn = 0.2;  // m/s, rad/s

Vector6 perAxis(double position, double angle) {
  Vector6 axes;
  axes << Eigen::Vector3d::Constant(position), Eigen::Vector3d::Constant(angle);
  return axes;
}

}  // namespace

void PoseFilter::addNoise(const Vector6& scale) {
  for (Pose& pose : poses_)
    pose = normalized(pose * expSe3(scale.cwiseProduct(random_.normalTwist())));
  noise_variance_ += scale.cwiseAbs2();
}

void PoseFilter::moveEstimate(const Pose& increment, const Twist& noise_before) {
  const Matrix6 to_new_axes = adjoint(increment.inverse());
  estimate_.mean = normalized(estimate_.mean * increment);
  estimate_.covariance = to_new_axes * estimate_.covariance * to_new_axes.transpose();
  estimate_.covariance.diagonal() += noise_variance_ - noise_before;
  covariance_.move(increment, noise_variance_ - noise_before);
}

void PoseFilter::predictWithOdometry(const Pose& increment, double dt) {
  if (!isValid(increment) || !std::isfinite(dt) || dt < 0)
    throw InputError(
        "filter: the odometry increment is not finite or not on earth, or its time is negative or "
        "not finite");
  resampleIfNeeded();
  const Vector6 noise_before = noise_variance_;
  for (Pose& pose : poses_) pose = pose * increment;
  addNoise(odometry_noise_factor_ * odometryNoise(params_, increment, dt));
  moveEstimate(increment, noise_before);
  since_last_estimate_ += dt;
}

void PoseFilter::predictWithoutOdometry(double dt, std::optional<double> elapsed) {
  if (!std::isfinite(dt) || dt < 0)
    throw InputError("filter: the time step is negative or not finite");
  resampleIfNeeded();
  const Pose increment = expSe3(velocity_ * timeOfVelocity(dt));
  const Vector6 noise_before = noise_variance_;
  for (Pose& pose : poses_) pose = pose * increment;
  addNoise(walkNoise(params_, dt));
  if (refinement_.enabled)
    moveByVelocity(increment, noise_variance_ - noise_before, dt, elapsed.value_or(dt));
  else
    moveEstimate(increment, noise_before);
  velocity_ *= keptVelocity(elapsed.value_or(dt));
  since_last_estimate_ += elapsed.value_or(dt);
}

void PoseFilter::moveByVelocity(const Pose& increment, const Vector6& noise, double dt,
                                double elapsed) {
  // The rest is what other modes add to the covariance.
  const Matrix6 rest = estimate_.covariance - covariance_.covariance();
  covariance_.moveByVelocity(
      increment, noise, dt, elapsed,
      perAxis(params_.walk_acceleration, params_.walk_angular_acceleration_deg * kDegree));
  const Matrix6 to_new_axes = adjoint(increment.inverse());
  estimate_.mean = normalized(estimate_.mean * increment);
  estimate_.covariance = to_new_axes * rest * to_new_axes.transpose() + covariance_.covariance();
  // The noise of each step is independent, but an error of the velocity stays. In directions that
  // the images do not show, it has moved the pose farther than the particles tell.
  const Matrix6 cloud = meanAndCovariance(poses_, normalizedWeights()).covariance;
  const Matrix6 excess = excessOver(cloud, covariance_.ofMotion());
  if (excess.isZero(0)) return;
  const GaussianDensity density({Pose::Identity(), excess});
  // Draws in pairs of opposite signs do not move the mean of the particles.
  Twist drawn = Twist::Zero();
  for (size_t i = 0; i < poses_.size(); ++i) {
    drawn = i % 2 == 0 ? density.drawOffset(&random_) : -drawn;
    poses_[i] = normalized(poses_[i] * expSe3(drawn));
  }
}

void PoseFilter::setVelocity(const Twist& velocity) {
  velocity_ = velocity;
  covariance_.setVelocity(perAxis(kKnownSpeed, kKnownTurn));
}

void PoseFilter::forgetVelocity() {
  velocity_.setZero();
  covariance_.forgetVelocity();
}

bool PoseFilter::correctTilt(const UpReading& reading) {
  if (!reading.up_base.allFinite() || reading.up_base.norm() < 0.5 || !(reading.sigma > 0))
    throw InputError(
        "filter: the reading of roll and pitch is not a finite direction with a positive sigma");
  if (!edge_mcl::correctTilt(reading, normalizedWeights(), &random_, &poses_)) return false;
  if (refinement_.enabled && covariance_.isByVelocity()) {
    const Eigen::Matrix<double, 6, 2> axes = tiltAxes(reading);
    const Eigen::Vector2d error =
        axes.bottomRows<3>().transpose() * tiltError(estimate_.mean, reading.up_base.normalized());
    velocity_ += covariance_.correctDirections(axes, reading.sigma) * error;
  }
  estimate_ = edge_mcl::correctTilt(reading, estimate_);
  return true;
}

void PoseFilter::correctVelocity(const PoseGaussian& predicted) {
  // Chi-square of six degrees of freedom: one Gaussian error in a million is larger. Such a pose
  // has jumped to another place rather than moved there.
  constexpr double kJump = 40;
  const Twist innovation = logSe3(predicted.mean.inverse() * estimate_.mean);
  const double distance = squaredMahalanobis(innovation, predicted.covariance);
  if (distance >= 0 && distance <= kJump)
    velocity_ += covariance_.velocityGain() * innovation;
  else
    forgetVelocity();
}

void PoseFilter::trackVelocity(const PoseGaussian& predicted) {
  if (refinement_.enabled && covariance_.isByVelocity()) {
    correctVelocity(predicted);
    last_estimate_ = estimate_;
    since_last_estimate_ = 0;
    return;
  }
  // Over a shorter time the velocity would be nothing but the noise of the estimates.
  constexpr double kShortest = 0.005;  // s
  if (last_estimate_ && since_last_estimate_ < kShortest) return;
  if (last_estimate_) {
    // While the filter converges, its estimates jump. Their covariance is large then, and the
    // newest velocity gets little weight against the velocity known before.
    const Twist newest =
        logSe3(last_estimate_->mean.inverse() * estimate_.mean) / since_last_estimate_;
    for (int i = 0; i < 6; ++i) {
      const double known = square(i < 3 ? kUsualSpeed : kUsualTurn);
      const double noise = (last_estimate_->covariance(i, i) + estimate_.covariance(i, i)) /
                           square(since_last_estimate_);
      velocity_[i] +=
          params_.velocity_smoothing * known / (known + noise) * (newest[i] - velocity_[i]);
    }
    covariance_.setVelocity(perAxis(kKnownSpeed, kKnownTurn));
  }
  last_estimate_ = estimate_;
  since_last_estimate_ = 0;
}

}  // namespace edge_mcl
