#include "edge_mcl/sim/sensor_noise.h"

#include <cmath>

namespace edge_mcl {

Pose OdometrySimulator::next(double time, const Pose& truth) {
  if (!started_) {
    started_ = true;
  } else {
    const Pose increment = last_truth_.inverse() * truth;
    const double root = std::sqrt((time - last_time_) / 0.1);
    const double position =
        noise_.position * root + noise_.per_metre * increment.translation().norm();
    const double angle = noise_.angle_deg * M_PI / 180 * root +
                         noise_.per_radian * logSo3(increment.linear()).norm();
    Vector6 scale;
    scale << position, position, position, angle, angle, angle;
    odometry_ =
        normalized(odometry_ * increment * expSe3(scale.cwiseProduct(random_.normalTwist())));
  }
  last_time_ = time;
  last_truth_ = truth;
  return odometry_;
}

Eigen::Vector3d ImuSensor::normal() {
  const double x = random_.normal(), y = random_.normal();
  return {x, y, random_.normal()};
}

ImuReading ImuSensor::read(double time, const Eigen::Matrix3d& body_to_map,
                           const Eigen::Vector3d& turn, const Eigen::Vector3d& acceleration) {
  const double dt = 1 / noise_.rate, root = std::sqrt(noise_.rate);
  const Eigen::Vector3d up(0, 0, FlightPath::kGravity);
  // White noise of density d that is sampled at rate f has the standard deviation d sqrt(f). A step
  // of a random walk of density d has the standard deviation d sqrt(dt).
  ImuReading reading{time, turn + turn_bias_,
                     body_to_map.transpose() * (acceleration + up) + force_bias_};
  reading.angular_velocity += noise_.gyroscope * root * normal();
  reading.specific_force += noise_.accelerometer * root * normal();
  force_bias_ += noise_.accelerometer_walk * std::sqrt(dt) * normal();
  turn_bias_ += noise_.gyroscope_walk * std::sqrt(dt) * normal();
  return reading;
}

std::vector<ImuReading> simulateImu(const FlightPath& path, const ImuNoise& noise, uint64_t seed) {
  ImuSensor sensor(noise, seed);
  const auto count = static_cast<size_t>(std::floor((path.end() - path.begin()) * noise.rate)) + 1;
  std::vector<ImuReading> readings;
  readings.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const double t = path.begin() + static_cast<double>(i) / noise.rate;
    readings.push_back(
        sensor.read(t, path.at(t).linear(), path.angularVelocity(t), path.acceleration(t)));
  }
  return readings;
}

}  // namespace edge_mcl
