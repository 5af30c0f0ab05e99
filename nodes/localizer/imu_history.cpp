#include "edge_mcl/nodes/localizer/imu_history.h"

#include <Eigen/Geometry>
#include <cmath>

#include "edge_mcl/core/base/clock_step.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

namespace {

Eigen::Matrix3d orientationOf(const sensor_msgs::Imu& message) {
  if (message.orientation_covariance[0] == -1)
    throw InputError("imu: its messages hold no orientation");
  geometry_msgs::Pose pose;
  pose.orientation = message.orientation;
  return fromMessage(pose, "imu").linear();
}

}  // namespace

void ImuHistory::add(const sensor_msgs::ImuConstPtr& message) {
  constexpr size_t kKept = 400;  // one second of a fast IMU; images may wait that long
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!messages_.empty() && clockStep(messages_.back()->header.stamp.toSec(),
                                      message->header.stamp.toSec()) == ClockStep::kJumpedBack)
    messages_.clear();
  messages_.push_back(message);
  if (messages_.size() > kKept) messages_.pop_front();
}

ImuOrientation ImuHistory::at(const ros::Time& stamp) const {
  constexpr double kSameMoment = 0.05;  // s; an IMU is faster than 20 Hz
  sensor_msgs::ImuConstPtr before, after;
  double since = kSameMoment, until = kSameMoment;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const sensor_msgs::ImuConstPtr& message : messages_) {
      const double offset = (message->header.stamp - stamp).toSec();
      if (offset <= 0 && -offset <= since) {
        since = -offset;
        before = message;
      }
      if (offset >= 0 && offset <= until && !(after && offset == until)) {
        until = offset;
        after = message;
      }
    }
  }
  if (!before && !after) throw InputError("no imu message for the image");
  if (!before || !after) {
    const sensor_msgs::Imu& only = before ? *before : *after;
    return {orientationOf(only), only.header};
  }
  const double whole = since + until, share = whole > 0 ? since / whole : 0;
  const Eigen::Quaterniond first(orientationOf(*before)), second(orientationOf(*after));
  return {first.slerp(share, second).toRotationMatrix(), before->header};
}

}  // namespace edge_mcl
