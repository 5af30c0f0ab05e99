#include "edge_mcl/sim/flight_path.h"

#include <cmath>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

void requireIncreasing(const std::vector<double>& times, const std::string& origin) {
  if (times.size() < 2) throw InputError(origin + ": a path needs at least two points");
  for (size_t i = 1; i < times.size(); ++i)
    if (!(times[i] > times[i - 1]))
      throw InputError(origin + ": the time of point " + std::to_string(i) +
                       " is not later than the time of the point before it");
}

}  // namespace

Eigen::Matrix3d attitudeFor(const Eigen::Vector3d& acceleration, double yaw) {
  const Eigen::Vector3d up =
      (acceleration + Eigen::Vector3d(0, 0, FlightPath::kGravity)).normalized();
  const Eigen::Vector3d heading(std::cos(yaw), std::sin(yaw), 0);
  const Eigen::Vector3d left = up.cross(heading).normalized();
  Eigen::Matrix3d attitude;
  attitude << left.cross(up), left, up;
  return attitude;
}

FlightPath FlightPath::throughWaypoints(const std::vector<Waypoint>& waypoints, bool tilts,
                                        const std::string& origin) {
  std::vector<double> times;
  std::vector<std::vector<double>> values(4);
  for (const Waypoint& w : waypoints) {
    if (!std::isfinite(w.time) || !w.position.allFinite() || !std::isfinite(w.yaw))
      throw InputError(origin + ": a waypoint has a number that is not finite");
    times.push_back(w.time);
    for (int k = 0; k < 3; ++k) values[k].push_back(w.position[k]);
    const double last = values[3].empty() ? w.yaw : values[3].back();
    values[3].push_back(last + std::remainder(w.yaw - last, 2 * M_PI));
  }
  requireIncreasing(times, origin);
  FlightPath path;
  path.attitude_ = tilts ? Attitude::kTilted : Attitude::kLevel;
  for (const auto& channel : values) path.channels_.emplace_back(times, channel);
  return path;
}

FlightPath FlightPath::throughPoses(const Trajectory& poses, const std::string& origin) {
  std::vector<double> times;
  std::vector<std::vector<double>> values(7);
  Eigen::Vector4d last = Eigen::Vector4d::Zero();
  for (const StampedPose& p : poses) {
    times.push_back(p.time);
    for (int k = 0; k < 3; ++k) values[k].push_back(p.pose.translation()[k]);
    Eigen::Vector4d q = Eigen::Quaterniond(p.pose.linear()).coeffs();
    if (q.dot(last) < 0) q = -q;  // both signs are the same rotation: take the nearer one
    for (int k = 0; k < 4; ++k) values[3 + k].push_back(q[k]);
    last = q;
  }
  requireIncreasing(times, origin);
  FlightPath path;
  path.attitude_ = Attitude::kQuaternion;
  for (const auto& channel : values) path.channels_.emplace_back(times, channel);
  return path;
}

Eigen::Vector3d FlightPath::derivative(double time, int order) const {
  return {channels_[0].at(time, order), channels_[1].at(time, order), channels_[2].at(time, order)};
}

Pose FlightPath::at(double time) const {
  Pose pose = Pose::Identity();
  pose.translation() = derivative(time, 0);
  if (attitude_ == Attitude::kQuaternion) {
    const Eigen::Quaterniond q(channels_[6].at(time), channels_[3].at(time), channels_[4].at(time),
                               channels_[5].at(time));
    pose.linear() = q.normalized().toRotationMatrix();
    return pose;
  }
  pose.linear() =
      attitudeFor(attitude_ == Attitude::kTilted ? acceleration(time)
                                                 : Eigen::Vector3d(Eigen::Vector3d::Zero()),
                  channels_[3].at(time));
  return pose;
}

Eigen::Vector3d FlightPath::angularVelocity(double time) const {
  // Central difference. With a step of 0.1 ms its error is far below the noise of any gyroscope.
  constexpr double kStep = 1e-4;
  const Eigen::Matrix3d before = at(time - kStep).linear(), after = at(time + kStep).linear();
  return logSo3(before.transpose() * after) / (2 * kStep);
}

}  // namespace edge_mcl
