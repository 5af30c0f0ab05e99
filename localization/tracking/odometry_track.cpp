#include "edge_mcl/localization/tracking/odometry_track.h"

#include <algorithm>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/localization/filter/motion_noise.h"

namespace edge_mcl {

namespace {

/// The part of a time in which the robot moved. Odometry gains no error at rest, and a robot that
/// moves is faster than these speeds.
double movingTime(const Pose& motion, double time) {
  constexpr double kSlow = 0.05, kSlowTurn = 3 * kDegree;  // m/s, rad/s
  return std::min(time,
                  motion.translation().norm() / kSlow + logSo3(motion.linear()).norm() / kSlowTurn);
}

}  // namespace

std::optional<Pose> OdometryTrack::incrementTo(const std::optional<Pose>& reading) const {
  if (!reading || !last_reading_) return std::nullopt;
  return normalized(last_reading_->inverse() * *reading);
}

void OdometryTrack::read(const std::optional<Pose>& reading) {
  if (!reading) return;
  last_reading_ = reading;
  carried_for_ = 0;
}

void OdometryTrack::carry(const Pose& motion, double dt, double longest) {
  if (!last_reading_) return;
  carried_for_ += dt;
  if (carried_for_ > longest)
    last_reading_.reset();
  else
    last_reading_ = normalized(*last_reading_ * motion);
}

void OdometryTrack::wait(const Pose& increment, double dt) {
  waiting_ = normalized(waiting_ * increment);
  waiting_time_ += dt;
  // In a longer step the clock has jumped, or the robot stood still for most of the time. Odometry
  // has told how far it moved. The spread of kJump seconds is one from which images find the pose.
  constexpr double kLongest = 60, kJump = 10;  // s
  last_step_ = dt > kLongest ? kJump : dt;
  if (!since_update_) return;
  *since_update_ = normalized(*since_update_ * increment);
}

OdometryStep OdometryTrack::corrected(const Pose& increment, double dt) const {
  const double factor = calibration_.noiseFactor();
  return {calibration_.corrected(increment, dt), dt, factor * odometryNoise(params_, increment, dt),
          factor};
}

OdometryStep OdometryTrack::waited() const {
  if (!isWaiting()) return {};
  return corrected(waiting_, std::max(movingTime(waiting_, waiting_time_), last_step_));
}

void OdometryTrack::endWaiting() {
  const OdometryStep step = waited();
  time_since_update_ += step.time;
  noise_since_update_ += step.sigma.cwiseAbs2() / (step.noise_factor * step.noise_factor);
  waiting_ = Pose::Identity();
  waiting_time_ = 0;
}

void OdometryTrack::interrupt() {
  waiting_ = Pose::Identity();
  waiting_time_ = 0;
  since_update_.reset();
}

void OdometryTrack::update(const UpdateReport& report, bool trusted) {
  if (trusted && since_update_ && params_.learn_odometry)
    calibration_.learn(*since_update_, time_since_update_, report.innovation, noise_since_update_,
                       report.innovation_of_images);
  since_update_ = Pose::Identity();
  time_since_update_ = 0;
  noise_since_update_.setZero();
}

}  // namespace edge_mcl
