/// Converts between ROS messages and the types of the library.
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovariance.h>
#include <geometry_msgs/Transform.h>
#include <geometry_msgs/TransformStamped.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

#include <string>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/recordings/recording.h"

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

/// Converts a calibration. @throws InputError that lists every fault
CameraModel fromMessage(const sensor_msgs::CameraInfo& message, const std::string& origin);
sensor_msgs::CameraInfo toCameraInfo(const CameraModel& camera, const ros::Time& stamp,
                                     const std::string& frame);

/// Makes a message with a copy of the pixels. @param encoding e.g. "bgr8", "mono8", "32FC1".
sensor_msgs::ImagePtr toImage(const cv::Mat& image, const std::string& encoding,
                              const ros::Time& stamp, const std::string& frame);
/// Converts an image to bgr8, mono8 or mono16. When no conversion is needed, the result shares the
/// pixels of the message. @throws InputError when the image is truncated or its encoding cannot be
/// converted
cv::Mat fromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);
/// Depth image of a message: 16UC1 or mono16 (millimetres), or 32FC1 (metres). It shares the pixels
/// of the message. @throws InputError when the image is truncated, has another encoding or is
/// big-endian
cv::Mat depthFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);
/// Mask of a message: mono8, non-zero = ignored. It shares the pixels of the message.
/// @throws InputError when the mask is truncated or has another encoding
cv::Mat maskFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);

/// Converts a reading of an IMU. The message has no orientation.
sensor_msgs::Imu toImu(const ImuReading& reading, const ros::Time& stamp, const std::string& frame);

}  // namespace edge_mcl
