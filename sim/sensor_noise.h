/// Odometry and inertial readings of a flight.
#pragma once

#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/sim/flight_path.h"

namespace edge_mcl {

/// Noise of one odometry step over time dt, distance d and angle a, per axis: standard deviation
/// position * sqrt(dt / 0.1 s) + per_metre * d, angle likewise. The filter's defaults.
struct OdometryNoise {
  double position = 0.01;    ///< m
  double angle_deg = 0.3;    ///< deg
  double per_metre = 0.03;   ///< m/m
  double per_radian = 0.02;  ///< rad/rad
};

/// Adds up noisy increments. Starts at identity.
class OdometrySimulator {
 public:
  OdometrySimulator(const OdometryNoise& noise, uint64_t seed) : noise_(noise), random_(seed) {}
  /// @param truth T_map_sensor. @return T_odom_sensor.
  Pose next(double time, const Pose& truth);

 private:
  OdometryNoise noise_;
  RandomSource random_;
  bool started_ = false;
  double last_time_ = 0;
  Pose last_truth_ = Pose::Identity(), odometry_ = Pose::Identity();
};

/// Continuous-time densities, as data sheets give them; defaults of a common MEMS unit.
struct ImuNoise {
  double rate = 200;                 ///< Hz
  double accelerometer = 2e-3;       ///< m/s^2 per sqrt(Hz)
  double gyroscope = 1.7e-4;         ///< rad/s per sqrt(Hz)
  double accelerometer_walk = 3e-3;  ///< m/s^3 per sqrt(Hz): bias
  double gyroscope_walk = 2e-5;      ///< rad/s^2 per sqrt(Hz): bias
};

/// An inertial sensor with its wandering biases.
class ImuSensor {
 public:
  ImuSensor(const ImuNoise& noise, uint64_t seed) : noise_(noise), random_(seed) {}
  /// The next reading; one every 1 / rate seconds. @param body_to_map rotation of the body.
  /// @param turn rad/s, body axes. @param acceleration m/s^2, map axes.
  ImuReading read(double time, const Eigen::Matrix3d& body_to_map, const Eigen::Vector3d& turn,
                  const Eigen::Vector3d& acceleration);

 private:
  Eigen::Vector3d normal();
  ImuNoise noise_;
  RandomSource random_;
  Eigen::Vector3d force_bias_ = Eigen::Vector3d::Zero(), turn_bias_ = Eigen::Vector3d::Zero();
};

/// Readings from the begin to the end of a path.
std::vector<ImuReading> simulateImu(const FlightPath& path, const ImuNoise& noise, uint64_t seed);

}  // namespace edge_mcl
