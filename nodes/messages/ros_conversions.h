/// Converts between ROS messages and the types of the library.
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Imu.h>

#include <string>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/nodes/messages/image_messages.h"

namespace edge_mcl {

/// Converts a pose to a message.
geometry_msgs::Pose toPoseMessage(const Pose& pose);
geometry_msgs::Transform toTransformMessage(const Pose& pose);
/// @param pose T_parent_child.
geometry_msgs::TransformStamped toTransformStamped(const Pose& pose, const ros::Time& stamp,
                                                   const std::string& parent,
                                                   const std::string& child);
/// Converts a pose with covariance. The covariance of the message is over (x, y, z, rotation about
/// the fixed axes), as in REP 103 and PoseWithCovariance, see covarianceInMapAxes().
geometry_msgs::PoseWithCovariance toPoseMessage(const PoseGaussian& gaussian);

/// Converts a message to a pose.
/// @param origin named in errors.
/// @throws InputError when a number is not finite, or the length of the quaternion differs from 1
/// by more than 0.01
Pose fromMessage(const geometry_msgs::Pose& message, const std::string& origin);
Pose fromMessage(const geometry_msgs::Transform& message, const std::string& origin);
/// Converts a message to a pose with covariance. @throws InputError when the pose is wrong (see
/// above), or the covariance is not finite, not symmetric or has a negative variance
PoseGaussian fromMessage(const geometry_msgs::PoseWithCovariance& message,
                         const std::string& origin);

/// Converts a calibration. ROI and binning are applied as image_geometry does, so the camera has
/// the size of the images.
/// @param rectified the images are rectified, so the matrix P counts, and there is no distortion.
/// @throws InputError that lists every fault
CameraModel fromMessage(const sensor_msgs::CameraInfo& message, const std::string& origin,
                        bool rectified = false);
/// Whether a topic of images is one of rectified images by its name: "rect" or "rectified" is a
/// word of it, as in image_rect_color and rect/image.
bool isRectifiedTopic(const std::string& topic);
/// A frame without the slash at its beginning. tf1 wrote one, and tf2 refuses it.
std::string frameName(const std::string& frame);
sensor_msgs::CameraInfo toCameraInfo(const CameraModel& camera, const ros::Time& stamp,
                                     const std::string& frame);

/// Converts a reading of an IMU. The message has no orientation.
sensor_msgs::Imu toImu(const ImuReading& reading, const ros::Time& stamp, const std::string& frame);

}  // namespace edge_mcl
