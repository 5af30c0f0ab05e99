/// Gives the pose, velocity and acceleration of the robot at any time of a flight.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/recordings/text_table.h"
#include "edge_mcl/sim/cubic_spline.h"

namespace edge_mcl {

/// A point that the path goes through.
struct Waypoint {
  double time = 0;           ///< seconds
  Eigen::Vector3d position;  ///< metres, map
  double yaw = 0;            ///< radians; between two waypoints the path turns the shorter way
};

/// Returns the attitude (map from body) of a multirotor that accelerates. Its thrust acts along the
/// body's z axis, makes the acceleration and carries the weight. The x axis points to the yaw as
/// far as the tilt allows. @param acceleration map axes, m/s^2. @param yaw rad.
Eigen::Matrix3d attitudeFor(const Eigen::Vector3d& acceleration, double yaw);

/// A smooth motion. Position, velocity and acceleration are continuous, so the readings of an
/// inertial sensor are defined at every time.
class FlightPath {
 public:
  /// Makes a path of the body through waypoints. @param tilts true: a multirotor that tilts, see
  /// attitudeFor(); false: the body stays level, like a person or a trolley. @param origin named in
  /// errors. @throws InputError for fewer than two waypoints, times that do not increase or a
  /// number that is not finite.
  static FlightPath throughWaypoints(const std::vector<Waypoint>& waypoints, bool tilts,
                                     const std::string& origin);
  /// Makes a path through recorded poses. The path gives poses of the same frame.
  /// @param origin named in errors. @throws InputError for fewer than two poses or times that do
  /// not increase.
  static FlightPath throughPoses(const Trajectory& poses, const std::string& origin);

  double begin() const { return channels_[0].begin(); }
  double end() const { return channels_[0].end(); }
  /// Pose of the moving frame in the map.
  Pose at(double time) const;
  /// Velocity in map axes, m/s.
  Eigen::Vector3d velocity(double time) const { return derivative(time, 1); }
  /// Acceleration in map axes, m/s^2, without gravity.
  Eigen::Vector3d acceleration(double time) const { return derivative(time, 2); }
  /// Angular velocity in the axes of the moving frame, rad/s.
  Eigen::Vector3d angularVelocity(double time) const;

  static constexpr double kGravity = 9.80665;  ///< m/s^2

 private:
  Eigen::Vector3d derivative(double time, int order) const;
  enum class Attitude { kLevel, kTilted, kQuaternion };
  Attitude attitude_ = Attitude::kLevel;
  std::vector<CubicSpline> channels_;  // x, y, z; then the yaw or the quaternion's x, y, z, w
};

}  // namespace edge_mcl
