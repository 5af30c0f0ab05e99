#include "edge_mcl/nodes/mavros/vision_gate.h"

#include "edge_mcl/core/base/angles.h"

namespace edge_mcl {

bool VisionGate::hasJumped(const Last& last, double time, const Pose& pose) const {
  const Pose expected = last.pose * expSe3((time - last.time) * last.velocity);
  const Pose error = expected.inverse() * pose;
  return error.translation().norm() > params_.jump ||
         logSo3(error.linear()).norm() > params_.jump_angle_deg * kDegree;
}

void VisionGate::update(double time, bool is_tracking, double probability, const Pose& pose) {
  if (!is_tracking || !(probability >= params_.min_probability)) {
    sure_since_.reset();
    return;
  }
  constexpr double kTooLong = 1;  // s without a sure image; the velocity is not known any more
  const bool goes_on = last_ && time > last_->time && time - last_->time < kTooLong;
  const bool has_jumped = goes_on && hasJumped(*last_, time, pose);
  // After a jump the new pose must hold for a while as well.
  if (!sure_since_ || !goes_on || has_jumped) {
    sure_since_ = time;
    was_open_ = false;
  }
  Twist velocity = Twist::Zero();
  if (goes_on && !has_jumped)
    velocity = logSe3(last_->pose.inverse() * pose) / (time - last_->time);
  last_ = Last{time, pose, velocity};
  if (isOpen(time) && !was_open_) {
    was_open_ = true;
    ++resets_;
  }
}

bool VisionGate::isOpen(double time) const {
  return sure_since_ && last_ && last_->time - *sure_since_ >= params_.settle &&
         time - last_->time <= params_.hold;
}

}  // namespace edge_mcl
