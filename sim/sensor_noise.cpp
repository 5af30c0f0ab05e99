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
    Twist scale;
    scale << position, position, position, angle, angle, angle;
    odometry_ =
        normalized(odometry_ * increment * expSe3(scale.cwiseProduct(random_.normalTwist())));
  }
  last_time_ = time;
  last_truth_ = truth;
  return odometry_;
}

std::vector<ImuReading> simulateImu(const FlightPath& path, const ImuNoise& noise, uint64_t seed) {
  RandomSource random(seed);
  const auto normal = [&] {
    return Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  };
  const double dt = 1 / noise.rate, root = std::sqrt(noise.rate);
  const auto count = static_cast<size_t>(std::floor((path.end() - path.begin()) * noise.rate)) + 1;
  Eigen::Vector3d force_bias = Eigen::Vector3d::Zero(), turn_bias = Eigen::Vector3d::Zero();
  std::vector<ImuReading> readings;
  readings.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const double t = path.begin() + static_cast<double>(i) * dt;
    const Eigen::Matrix3d to_body = path.at(t).linear().transpose();
    const Eigen::Vector3d up(0, 0, FlightPath::kGravity);
    // White noise of density d sampled at rate f has standard deviation d sqrt(f); a walk of
    // density d grows by d sqrt(dt) a step.
    readings.push_back({t, path.angularVelocity(t) + turn_bias + noise.gyroscope * root * normal(),
                        to_body * (path.acceleration(t) + up) + force_bias +
                            noise.accelerometer * root * normal()});
    force_bias += noise.accelerometer_walk * std::sqrt(dt) * normal();
    turn_bias += noise.gyroscope_walk * std::sqrt(dt) * normal();
  }
  return readings;
}

}  // namespace edge_mcl
