/// Gives the localizer's poses to an autopilot through MAVROS.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <edge_mcl/Status.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>

#include <map>
#include <mutex>
#include <vector>

#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/nodes/common/wall_pace.h"
#include "edge_mcl/nodes/mavros/vision_gate.h"

namespace edge_mcl {

/// Parameters of the node. The functions of parameter_struct.h work with them.
struct MavrosNodeParameters : VisionGateParameters {
  double max_rate = 30;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_rate", max_rate, "Hz", above(0, 1000), "largest rate at which poses are published");
    VisionGateParameters::visit(v);
  }
};

/// Subscribes to `pose`, `odometry/filtered` and `status` of the localizer. Publishes
/// `mavros/vision_pose/pose_cov`, `mavros/odometry/out` (with odometry) and `~reset_counter`. The
/// frames are those of ROS (ENU, FLU); MAVROS turns them into those of the autopilot.
///
/// With messages on `odometry/filtered`, poses have their times and rate; otherwise those of the
/// images.
class MavrosNode {
 public:
  /// @throws ParameterError
  MavrosNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

 private:
  void receivePose(const geometry_msgs::PoseWithCovarianceStampedConstPtr& pose);
  void receiveStatus(const StatusConstPtr& status);
  void receiveOdometry(const nav_msgs::OdometryConstPtr& odometry);
  /// Publishes a pose when the gate is open and the rate allows it. @return whether it was
  /// published
  bool publish(const geometry_msgs::PoseWithCovarianceStamped& pose);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  const MavrosNodeParameters params_;
  std::mutex mutex_;
  VisionGate gate_;
  /// Poses whose status has not come yet, by stamp.
  std::map<ros::Time, geometry_msgs::PoseWithCovarianceStampedConstPtr> waiting_;
  std::optional<double> odometry_at_;  // receipt of the newest odometry, s by the wall clock
  std::optional<ros::Time> published_at_;
  double delay_ = 0;  // s, mean from the stamp of a pose to its publication
  uint32_t published_ = 0, withheld_ = 0;
  ros::Publisher pose_, odometry_, resets_;
  std::vector<ros::Subscriber> subscribers_;
  diagnostic_updater::Updater diagnostics_;
  WallPace diagnostics_pace_;
  ros::WallTimer diagnostics_timer_;
};

}  // namespace edge_mcl
