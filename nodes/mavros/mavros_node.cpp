#include "edge_mcl/nodes/mavros/mavros_node.h"

#include <ros/console.h>
#include <std_msgs/UInt8.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/common/private_parameters.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

MavrosNode::MavrosNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh)
    : params_(readParameterStruct<MavrosNodeParameters>(private_nh)),
      gate_(params_),
      diagnostics_(nh, private_nh) {
  ros::NodeHandle handle(nh), own(private_nh);
  pose_ =
      handle.advertise<geometry_msgs::PoseWithCovarianceStamped>("mavros/vision_pose/pose_cov", 10);
  odometry_ = handle.advertise<nav_msgs::Odometry>("mavros/odometry/out", 10);
  resets_ = own.advertise<std_msgs::UInt8>("reset_counter", 1, true);
  resets_.publish(std_msgs::UInt8());
  subscribers_.push_back(handle.subscribe("pose", 20, &MavrosNode::receivePose, this));
  subscribers_.push_back(handle.subscribe("status", 20, &MavrosNode::receiveStatus, this));
  subscribers_.push_back(
      handle.subscribe("odometry/filtered", 50, &MavrosNode::receiveOdometry, this));
  diagnostics_.setHardwareID("edge_mcl");
  diagnostics_.add("vision for the autopilot", this, &MavrosNode::diagnose);
  diagnostics_timer_ =
      handle.createWallTimer(ros::WallDuration(0.1), [this](const ros::WallTimerEvent&) {
        if (diagnostics_pace_.isDue(diagnostics_.getPeriod())) diagnostics_.force_update();
      });
}

void MavrosNode::receivePose(const geometry_msgs::PoseWithCovarianceStampedConstPtr& pose) {
  constexpr size_t kMost = 20;  // the status of an image follows its pose at once
  const std::lock_guard<std::mutex> lock(mutex_);
  waiting_[pose->header.stamp] = pose;
  if (waiting_.size() > kMost) waiting_.erase(waiting_.begin());
}

void MavrosNode::receiveStatus(const StatusConstPtr& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = waiting_.find(status->header.stamp);
  const bool has_pose = found != waiting_.end();
  const auto pose = has_pose ? found->second : nullptr;
  waiting_.erase(waiting_.begin(), waiting_.upper_bound(status->header.stamp));
  const uint8_t before = gate_.resets();
  try {
    gate_.update(status->header.stamp.toSec(), has_pose && status->state == Status::TRACKING,
                 static_cast<double>(status->probability),
                 has_pose ? fromMessage(pose->pose.pose, "pose") : Pose::Identity());
  } catch (const InputError& e) {
    ROS_WARN_THROTTLE(5, "%s, left out", e.what());
    return;
  }
  if (gate_.resets() != before) {
    std_msgs::UInt8 count;
    count.data = gate_.resets();
    resets_.publish(count);
    ROS_INFO("poses are passed on; reset counter %d", static_cast<int>(gate_.resets()));
  }
  constexpr double kOdometryRuns = 0.5;  // s
  const bool by_odometry =
      odometry_at_ && ros::WallTime::now().toSec() - *odometry_at_ < kOdometryRuns;
  if (pose && !by_odometry) publish(*pose);
}

void MavrosNode::receiveOdometry(const nav_msgs::OdometryConstPtr& odometry) {
  const std::lock_guard<std::mutex> lock(mutex_);
  odometry_at_ = ros::WallTime::now().toSec();
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header = odometry->header;
  pose.pose = odometry->pose;
  if (publish(pose)) odometry_.publish(odometry);
}

bool MavrosNode::publish(const geometry_msgs::PoseWithCovarianceStamped& pose) {
  const ros::Time& stamp = pose.header.stamp;
  if (!gate_.isOpen(stamp.toSec())) {
    ++withheld_;
    return false;
  }
  // A pose of the right time may come a little early.
  constexpr double kEarly = 0.9;
  if (published_at_ && stamp > *published_at_ &&
      (stamp - *published_at_).toSec() < kEarly / params_.max_rate)
    return false;
  published_at_ = stamp;
  pose_.publish(pose);
  constexpr double kNew = 0.05;  // the mean is over some twenty poses
  const double delay = (ros::Time::now() - stamp).toSec();
  delay_ = published_ == 0 ? delay : (1 - kNew) * delay_ + kNew * delay;
  ++published_;
  return true;
}

void MavrosNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool is_open = published_at_ && gate_.isOpen(published_at_->toSec());
  status.summary(is_open ? Level::OK : Level::WARN,
                 is_open ? "poses are passed on" : "no pose is passed on");
  status.add("delay ms", 1000 * delay_);
  status.add("poses published", published_);
  status.add("poses withheld", withheld_);
  status.add("reset counter", static_cast<int>(gate_.resets()));
}

}  // namespace edge_mcl
