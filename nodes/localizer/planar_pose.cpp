#include "edge_mcl/nodes/localizer/planar_pose.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/places/free_space.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

namespace {

struct Height {
  double mean, sigma;  // m
};

/// Height of a robot that may be anywhere between floor and ceiling at a place.
Height freeHeightAt(const LocalizationMap& map, const Eigen::Vector2d& place) {
  constexpr double kStep = 0.1;  // m
  constexpr double kHighest =
      2.5;                        // m above the floor; robots that look at a room seldom fly higher
  constexpr double kLeast = 0.5;  // m; lower stretches are inside furniture
  const auto low = static_cast<double>(map.mesh().lowest.z());
  const auto high = static_cast<double>(map.mesh().highest.z());
  const std::shared_ptr<const FreeSpace> space = map.freeSpace();
  // The free stretch that is nearest to the plane z = 0, on which the tool has set the pose.
  Height best{std::min(high, std::max(low, 0.0)) + 1, 1};
  double nearest = INFINITY, begin = NAN;
  for (double z = low; z <= high + kStep; z += kStep) {
    const bool is_free = z <= high && space->contains({place.x(), place.y(), z});
    if (is_free && std::isnan(begin)) begin = z;
    if (is_free || std::isnan(begin)) continue;
    const double end = std::min(z - kStep, begin + kHighest);
    if (const double distance = std::abs(begin); distance < nearest && end - begin >= kLeast) {
      nearest = distance;
      // The standard deviation of a uniform distribution over the stretch.
      best = {(begin + end) / 2, std::max(0.2, (end - begin) / std::sqrt(12.0))};
    }
    begin = NAN;
  }
  return best;
}

/// Turns a pose about a horizontal axis until its "up" is that of a reading.
Eigen::Matrix3d tilted(const Eigen::Matrix3d& level, const Eigen::Vector3d& up_base) {
  const Eigen::Vector3d up_map = level * up_base;
  return Eigen::Quaterniond::FromTwoVectors(up_map, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
         level;
}

}  // namespace

bool isPlanar(const geometry_msgs::PoseWithCovariance& message) {
  const auto variance = [&](size_t i) { return message.covariance[7 * i]; };
  const geometry_msgs::Quaternion& q = message.pose.orientation;
  return variance(0) > 0 && variance(1) > 0 && variance(2) == 0 && variance(3) == 0 &&
         variance(4) == 0 && message.pose.position.z == 0 && q.x == 0 && q.y == 0;
}

PoseGaussian completePlanar(const geometry_msgs::PoseWithCovariance& message,
                            const LocalizationMap& map, const PlanarContext& context) {
  constexpr double kPosition = 0.5, kHeading = 15 * kDegree;  // what a click in RViz is good for
  constexpr double kTilt = 8 * kDegree;  // of a robot that is not known to tilt
  constexpr double kHeightOfLast = 0.3;  // m
  PoseGaussian pose;
  pose.mean = fromMessage(message.pose, "initial pose");
  const Eigen::Matrix3d heading = pose.mean.linear();
  if (context.is_camera_base) pose.mean.linear() = heading * opticalOnBody().linear();
  double tilt_sigma = kTilt;
  std::optional<Eigen::Vector3d> up;
  if (context.last) up = context.last->mean.linear().transpose() * Eigen::Vector3d::UnitZ();
  if (context.up) {
    up = context.up->up_base;
    tilt_sigma = std::max(2 * kDegree, context.up->sigma);
  }
  if (up) pose.mean.linear() = tilted(pose.mean.linear(), *up);
  Height height = freeHeightAt(map, pose.mean.translation().head<2>());
  if (context.last) height = {context.last->mean.translation().z(), kHeightOfLast};
  pose.mean.translation().z() = height.mean;
  Matrix6 covariance = Matrix6::Zero();  // in map axes
  covariance.diagonal() << std::max(message.covariance[0], kPosition * kPosition),
      std::max(message.covariance[7], kPosition * kPosition), height.sigma * height.sigma,
      tilt_sigma * tilt_sigma, tilt_sigma * tilt_sigma,
      std::max(message.covariance[35], kHeading * kHeading);
  pose.covariance = covarianceFromMapAxes(pose.mean, covariance);
  return pose;
}

std::string hintBeside(const MeshModel& mesh, const Eigen::Vector3d& position) {
  const Eigen::Array2d place = position.head<2>().array();
  const Eigen::Array2d low = mesh.lowest.head<2>().cast<double>().array();
  const Eigen::Array2d high = mesh.highest.head<2>().cast<double>().array();
  if ((place >= low).all() && (place <= high).all()) return "";
  return cv::format(
      "the position is beside the model, which lies from x = %.1f to %.1f m and from y = %.1f to "
      "%.1f m",
      low.x(), high.x(), low.y(), high.y());
}

}  // namespace edge_mcl
