/// Simulates a multirotor that is flown by velocity commands.
#pragma once

#include <functional>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// How the multirotor responds to commands.
struct FlightResponse {
  double max_speed = 2;          ///< m/s
  double max_acceleration = 3;   ///< m/s^2
  double max_yaw_rate = 1.5;     ///< rad/s
  double velocity_time = 0.4;    ///< s until two thirds of a change of velocity are reached
  double attitude_time = 0.1;    ///< s until two thirds of a change of tilt are reached
  double command_timeout = 0.5;  ///< s without a command until the body hovers
};

/// State of the multirotor: position, velocity, acceleration, yaw and yaw rate. Acceleration and
/// yaw rate lag behind the command. The thrust acts along the body's z axis, makes the acceleration
/// and carries the weight, so the body tilts. The body stops at walls.
class LiveFlight {
 public:
  /// @param start T_map_body; only its position and yaw are used. @param isFree whether the body
  /// may move straight from a to b (map, m).
  LiveFlight(const Pose& start, const FlightResponse& response,
             std::function<bool(const Eigen::Vector3d& a, const Eigen::Vector3d& b)> isFree);

  /// Sets the wanted velocity and yaw rate, cut to the limits of FlightResponse. @param time s.
  /// @param velocity m/s in the level frame that turns with the body (x forward, z up).
  /// @param yaw_rate rad/s. @throws InputError when a number is not finite.
  void command(double time, const Eigen::Vector3d& velocity, double yaw_rate);
  /// Moves on to a time (s). The first call only sets the clock. @return false when a wall was in
  /// the way; the body stands still at the wall.
  bool advance(double time);

  /// T_map_body.
  Pose pose() const;
  /// T_map_body at a time shortly before or after now, extrapolated with the present velocity and
  /// angular velocity.
  Pose poseNear(double time) const;
  Eigen::Vector3d velocity() const { return velocity_; }          ///< map axes, m/s
  Eigen::Vector3d acceleration() const { return acceleration_; }  ///< map axes, m/s^2
  /// Body axes, rad/s; mean over the last call of advance() that was longer than 1 us.
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
