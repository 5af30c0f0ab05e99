#include "edge_mcl/nodes/messages/sensor_mounting.h"

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

}  // namespace edge_mcl
