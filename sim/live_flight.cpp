#include "edge_mcl/sim/live_flight.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/sim/flight_path.h"

namespace edge_mcl {

namespace {

/// Share of a change that a first-order lag reaches after a step.
double shareReached(double step, double time_constant) {
  return time_constant > 0 ? 1 - std::exp(-step / time_constant) : 1;
}

Eigen::Vector3d limited(const Eigen::Vector3d& v, double most) {
  return v.norm() > most ? Eigen::Vector3d(v * (most / v.norm())) : v;
}

}  // namespace

LiveFlight::LiveFlight(const Pose& start, const FlightResponse& response,
                       std::function<bool(const Eigen::Vector3d&, const Eigen::Vector3d&)> isFree)
    : response_(response), isFree_(std::move(isFree)), position_(start.translation()) {
  const Eigen::Vector3d forward = start.linear().col(0);
  yaw_ = std::atan2(forward.y(), forward.x());
}

void LiveFlight::command(double time, const Eigen::Vector3d& velocity, double yaw_rate) {
  if (!velocity.allFinite() || !std::isfinite(yaw_rate))
    throw InputError("flight: the command is not finite");
  commanded_at_ = time;
  wanted_velocity_ = limited(velocity, response_.max_speed);
  wanted_yaw_rate_ = std::clamp(yaw_rate, -response_.max_yaw_rate, response_.max_yaw_rate);
}

bool LiveFlight::advance(double time) {
  if (!started_) {
    started_ = true;
    time_ = time;
    return true;
  }
  constexpr double kStep = 0.005;  // s; 1/20 of the shortest default lag
  const Eigen::Matrix3d before = pose().linear();
  const double from = time_;
  bool free = true;
  while (time_ < time) {
    const double dt = std::min(kStep, time - time_);
    time_ = time - time_ <= kStep ? time : time_ + kStep;
    const bool hover = time_ - commanded_at_ > response_.command_timeout;
    yaw_rate_ +=
        shareReached(dt, response_.attitude_time) * ((hover ? 0 : wanted_yaw_rate_) - yaw_rate_);
    yaw_ += yaw_rate_ * dt;
    const Eigen::Vector3d wanted =
        hover
            ? Eigen::Vector3d(Eigen::Vector3d::Zero())
            : Eigen::Vector3d(Eigen::AngleAxisd(yaw_, Eigen::Vector3d::UnitZ()) * wanted_velocity_);
    const Eigen::Vector3d asked =
        limited((wanted - velocity_) / response_.velocity_time, response_.max_acceleration);
    acceleration_ += shareReached(dt, response_.attitude_time) * (asked - acceleration_);
    velocity_ += acceleration_ * dt;
    const Eigen::Vector3d next = position_ + velocity_ * dt;
    if (isFree_(position_, next)) {
      position_ = next;
    } else {
      velocity_.setZero();
      acceleration_.setZero();
      free = false;
    }
  }
  constexpr double kShortest = 1e-6;  // s; a shorter step would show only the rounding of attitudes
  if (time - from > kShortest)
    angular_velocity_ = logSo3(before.transpose() * pose().linear()) / (time - from);
  return free;
}

Pose LiveFlight::pose() const {
  Pose pose = Pose::Identity();
  pose.translation() = position_;
  pose.linear() = attitudeFor(acceleration_, yaw_);
  return pose;
}

Pose LiveFlight::poseNear(double time) const {
  Pose near = pose();
  near.translation() += (time - time_) * velocity_;
  near.linear() *= expSo3((time - time_) * angular_velocity_);
  return near;
}

}  // namespace edge_mcl
