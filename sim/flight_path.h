/// Where the robot is at any time.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/recordings/text_table.h"
#include "edge_mcl/sim/cubic_spline.h"

namespace edge_mcl {

/// A point that is flown through.
struct Waypoint {
  double time = 0;           ///< seconds
  Eigen::Vector3d position;  ///< metres, map
  double yaw = 0;            ///< radians; unwrapped along the path, the shorter way round
};

/// Attitude of a multirotor whose thrust, along its z axis, makes an acceleration (map axes, m/s^2)
/// against gravity; its x axis points to the yaw as far as the tilt allows.
Eigen::Matrix3d attitudeFor(const Eigen::Vector3d& acceleration, double yaw);

/// A smooth motion: position, velocity and acceleration are continuous, so an inertial sensor's
/// readings are defined everywhere.
class FlightPath {
 public:
  /// Through waypoints. @param tilts a multirotor leans into its acceleration: its thrust is along
  /// its z axis; without, it stays level (a person, a trolley).
  /// @throws InputError on fewer than two waypoints or times that do not increase.
  static FlightPath throughWaypoints(const std::vector<Waypoint>& waypoints, bool tilts,
                                     const std::string& origin);
  /// Through recorded poses of the base. @throws InputError likewise.
  static FlightPath throughPoses(const Trajectory& poses, const std::string& origin);

  double begin() const { return channels_[0].begin(); }
  double end() const { return channels_[0].end(); }
  Pose at(double time) const;
  /// In map axes.
  Eigen::Vector3d velocity(double time) const { return derivative(time, 1); }
  Eigen::Vector3d acceleration(double time) const { return derivative(time, 2); }
  /// In body axes, rad/s.
  Eigen::Vector3d angularVelocity(double time) const;

  static constexpr double kGravity = 9.80665;

 private:
  Eigen::Vector3d derivative(double time, int order) const;
  enum class Attitude { kLevel, kTilted, kQuaternion };
  Attitude attitude_ = Attitude::kLevel;
  std::vector<CubicSpline> channels_;  // x, y, z, then yaw or the quaternion x, y, z, w
};

}  // namespace edge_mcl
