/// A multirotor that is flown by velocity commands.
#pragma once

#include <functional>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// How it answers to commands.
struct FlightResponse {
  double max_speed = 2;          ///< m/s
  double max_acceleration = 3;   ///< m/s^2
  double max_yaw_rate = 1.5;     ///< rad/s
  double velocity_time = 0.4;    ///< s, in which two thirds of a change of velocity are reached
  double attitude_time = 0.1;    ///< s, in which two thirds of a tilt are reached
  double command_timeout = 0.5;  ///< s without a command before it hovers
};

/// Position and velocity, with an acceleration that lags behind what the command asks for; the
/// thrust, along the body's z axis, makes the acceleration and carries the weight, so the body
/// tilts. It stops at walls.
class LiveFlight {
 public:
  /// @param start its position and yaw. @param isFree whether the body may move from a to b.
  LiveFlight(const Pose& start, const FlightResponse& response,
             std::function<bool(const Eigen::Vector3d& a, const Eigen::Vector3d& b)> isFree);

  /// @param velocity m/s in the level frame that turns with the body (x forward, z up).
  /// @param yaw_rate rad/s. @throws InputError when a number is not finite.
  void command(double time, const Eigen::Vector3d& velocity, double yaw_rate);
  /// Moves on to a time. @return false when a wall is in the way: it stands still there.
  bool advance(double time);

  /// T_map_body.
  Pose pose() const;
  /// T_map_body shortly before or after, as it moves and turns now.
  Pose poseNear(double time) const;
  Eigen::Vector3d velocity() const { return velocity_; }          ///< map axes
  Eigen::Vector3d acceleration() const { return acceleration_; }  ///< map axes
  /// Body axes, mean over the last step that was not very short.
  Eigen::Vector3d angularVelocity() const { return angular_velocity_; }

 private:
  FlightResponse response_;
  std::function<bool(const Eigen::Vector3d&, const Eigen::Vector3d&)> isFree_;
  double time_ = 0, commanded_at_ = -1e9;
  bool started_ = false;
  Eigen::Vector3d wanted_velocity_ = Eigen::Vector3d::Zero();
  double wanted_yaw_rate_ = 0;
  Eigen::Vector3d position_, velocity_ = Eigen::Vector3d::Zero(),
                             acceleration_ = Eigen::Vector3d::Zero(),
                             angular_velocity_ = Eigen::Vector3d::Zero();
  double yaw_ = 0, yaw_rate_ = 0;
};

}  // namespace edge_mcl
