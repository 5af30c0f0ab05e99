#include "edge_mcl/nodes/messages/sensor_mounting.h"

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

Pose sensorMounting(const tf2::BufferCore& transforms, const std::string& base_frame,
                    const std_msgs::Header& header, const std::string& origin) {
  const std::string& frame = header.frame_id;
  if (frame == base_frame) return Pose::Identity();
  ros::Time at = header.stamp;
  std::string why;
  if (!transforms.canTransform(base_frame, frame, at)) at = ros::Time(0);
  if (!transforms.canTransform(base_frame, frame, at, &why))
    throw InputError(origin + ": where is it on the robot? " + why);
  return fromMessage(transforms.lookupTransform(base_frame, frame, at).transform, origin);
}

Pose baseMotion(const tf2::BufferCore& odometry, const std::string& odom_frame,
                const std::string& base_frame, const ros::Time& moment, const ros::Time& stamp) {
  constexpr double kLongest = 1;  // s; messages of one moment are hardly farther apart
  if (stamp == moment || std::abs((stamp - moment).toSec()) > kLongest) return Pose::Identity();
  // A rig that stands without odometry is no fault, so this asks first.
  if (!odometry.canTransform(base_frame, moment, base_frame, stamp, odom_frame))
    return Pose::Identity();
  return fromMessage(
      odometry.lookupTransform(base_frame, moment, base_frame, stamp, odom_frame).transform,
      "odometry");
}

}  // namespace edge_mcl
