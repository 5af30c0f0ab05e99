/// Simulates a flight and publishes the topics of a robot: images, depth, masks, odometry, IMU and
/// ground truth.
#pragma once

#include <geometry_msgs/Twist.h>
#include <ros/node_handle.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "edge_mcl/nodes/messages/recording_messages.h"
#include "edge_mcl/sim/live_flight.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {

/// The simulator node. Its private parameters are `scenario` (YAML file), `live` (`cmd_vel` flies
/// the robot in place of the scenario's path), `speed` (factor on real time; 0: as fast as
/// possible) and `seed`. An unknown parameter is an error.
///
/// With `use_sim_time` the node publishes `/clock`, and the clock waits for the images. Without
/// `use_sim_time`, stamps come from the wall clock, and images that cannot be made in time are left
/// out.
class SimulatorNode {
 public:
  /// @throws ParameterError for a wrong parameter; InputError when the scenario cannot be used
  SimulatorNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);
  /// Flies until the path ends or ROS shuts down.
  void run();

 private:
  double endTime() const;
  Pose cameraAt(double time) const;
  Eigen::Matrix3d attitudeAt(double time) const;
  void advanceTo(double time);
  void publishImage(double time);
  void pace(double time);
  ros::Time stampOf(double time) const;

  ros::NodeHandle nh_;
  bool live_ = false, simulated_clock_ = false;
  double speed_ = 1;
  std::unique_ptr<Simulator> simulator_;
  std::unique_ptr<RecordingMessages> messages_;
  std::unique_ptr<LiveFlight> flight_;
  std::unique_ptr<ImuSensor> imu_;
  std::mutex command_mutex_;
  std::optional<geometry_msgs::Twist> command_;
  ros::Publisher clock_, image_, info_, depth_, depth_info_, mask_, imu_publisher_, odometry_,
      truth_, initial_pose_;
  ros::Subscriber command_subscriber_;
  tf2_ros::TransformBroadcaster broadcaster_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  ros::WallTime started_;
  ros::Time epoch_;  ///< stamp of the beginning of the flight
  double begin_ = 0, imu_time_ = 0;
  size_t images_ = 0;
};

}  // namespace edge_mcl
