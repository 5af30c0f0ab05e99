/// A simulated flight as a robot's topics: images, depth, masks, odometry, IMU, truth.
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

/// Private parameters: `scenario` (YAML file), `live` (fly by cmd_vel instead of the scenario's
/// path), `speed` (times real time; 0: as fast as it can), `seed`. Unknown ones are an error.
///
/// With use_sim_time it publishes /clock, and the clock waits for the images; without, stamps are
/// of the wall clock and images that cannot be made in time are left out.
class SimulatorNode {
 public:
  /// @throws ParameterError, InputError
  SimulatorNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);
  /// Flies until the path or ROS ends.
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
  ros::Time epoch_;  ///< of time 0 of the flight
  double begin_ = 0, imu_time_ = 0;
  size_t images_ = 0;
};

}  // namespace edge_mcl
