/// Between ROS messages and the library's types.
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

geometry_msgs::Pose toPoseMessage(const Pose& pose);
geometry_msgs::Transform toTransformMessage(const Pose& pose);
geometry_msgs::TransformStamped toTransformStamped(const Pose& pose, const ros::Time& stamp,
                                                   const std::string& parent,
                                                   const std::string& child);
/// Covariance over (x, y, z, rotation about the fixed axes), as REP 103 and PoseWithCovariance have
/// it; see covarianceInMapAxes.
geometry_msgs::PoseWithCovariance toPoseMessage(const PoseGaussian& gaussian);

/// @throws InputError when a number is not finite or the quaternion is not of unit length (to one
/// percent), naming `origin`.
Pose fromMessage(const geometry_msgs::Pose& message, const std::string& origin);
Pose fromMessage(const geometry_msgs::Transform& message, const std::string& origin);
/// @throws InputError likewise, and when the covariance is not finite, not symmetric or has a
/// negative variance.
PoseGaussian fromMessage(const geometry_msgs::PoseWithCovariance& message,
                         const std::string& origin);

/// @throws InputError listing every fault.
CameraModel fromMessage(const sensor_msgs::CameraInfo& message, const std::string& origin);
sensor_msgs::CameraInfo toCameraInfo(const CameraModel& camera, const ros::Time& stamp,
                                     const std::string& frame);

/// Copies the pixels. @param encoding e.g. "bgr8", "mono8", "32FC1".
sensor_msgs::ImagePtr toImage(const cv::Mat& image, const std::string& encoding,
                              const ros::Time& stamp, const std::string& frame);
/// Shares the message's pixels where no conversion is needed: colour (bgr8) or grey (mono8).
/// @throws InputError on a truncated image or an encoding that means nothing here.
cv::Mat fromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);
/// Shares a depth image: 16UC1 or mono16 (millimetres) or 32FC1 (metres). @throws InputError
cv::Mat depthFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);
/// An ignore mask: mono8, non-zero = ignore. @throws InputError
cv::Mat maskFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);

sensor_msgs::Imu toImu(const ImuReading& reading, const ros::Time& stamp, const std::string& frame);

}  // namespace edge_mcl
