/// Simulates odometry and inertial readings of a flight, with noise.
#pragma once

#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/sim/flight_path.h"

namespace edge_mcl {

/// Noise of the simulated odometry. A step takes the time dt, moves by the distance d and turns by
/// the angle a. Per axis, the standard deviation of its translation is position * sqrt(dt / 0.1 s)
/// + per_metre * d. The standard deviation of its rotation is angle_deg * sqrt(dt / 0.1 s) +
/// per_radian * a.
struct OdometryNoise {
  double position = 0.01;    ///< m
  double angle_deg = 0.3;    ///< deg
  double per_metre = 0.03;   ///< m/m
  double per_radian = 0.02;  ///< rad/rad
};

/// Makes odometry: adds noise to every true increment and adds the increments up. The first pose is
/// identity.
class OdometrySimulator {
 public:
  OdometrySimulator(const OdometryNoise& noise, uint64_t seed) : noise_(noise), random_(seed) {}
  /// Returns the odometry at a time (s). @param truth T_map_sensor. @return T_odom_sensor.
  Pose next(double time, const Pose& truth);

 private:
  OdometryNoise noise_;
  RandomSource random_;
  bool started_ = false;
  double last_time_ = 0;
  Pose last_truth_ = Pose::Identity(), odometry_ = Pose::Identity();
};

/// Noise of the inertial sensor as continuous-time densities, as in data sheets. The defaults are
/// typical of a common MEMS sensor.
struct ImuNoise {
  double rate = 200;                 ///< readings per second, Hz
  double accelerometer = 2e-3;       ///< white noise, m/s^2 per sqrt(Hz)
  double gyroscope = 1.7e-4;         ///< white noise, rad/s per sqrt(Hz)
  double accelerometer_walk = 3e-3;  ///< random walk of the bias, m/s^3 per sqrt(Hz)
  double gyroscope_walk = 2e-5;      ///< random walk of the bias, rad/s^2 per sqrt(Hz)
};

/// Simulates an inertial sensor. Its biases start at 0 and follow a random walk.
class ImuSensor {
 public:
  ImuSensor(const ImuNoise& noise, uint64_t seed) : noise_(noise), random_(seed) {}
  /// Returns the next reading. Calls must be 1 / rate seconds apart. @param time s.
  /// @param body_to_map rotation of the body. @param turn angular velocity, rad/s, body axes.
  /// @param acceleration m/s^2, map axes, without gravity.
  ImuReading read(double time, const Eigen::Matrix3d& body_to_map, const Eigen::Vector3d& turn,
                  const Eigen::Vector3d& acceleration);

 private:
  Eigen::Vector3d normal();
  ImuNoise noise_;
  RandomSource random_;
  Eigen::Vector3d force_bias_ = Eigen::Vector3d::Zero(), turn_bias_ = Eigen::Vector3d::Zero();
};

/// Makes inertial readings from the begin to the end of a path.
std::vector<ImuReading> simulateImu(const FlightPath& path, const ImuNoise& noise, uint64_t seed);

}  // namespace edge_mcl
