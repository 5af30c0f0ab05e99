/// A recorded moment as the messages a robot would publish.
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

/// Frames of the messages, after REP 105.
struct RecordingFrames {
  std::string map = "map", odom = "odom", base = "base_link", camera = "camera_optical";
};

/// Topics relative to a namespace.
namespace recording_topics {
inline constexpr const char* kImage = "camera/image_raw";
inline constexpr const char* kInfo = "camera/camera_info";
inline constexpr const char* kDepth = "camera/depth/image_raw";
inline constexpr const char* kDepthInfo = "camera/depth/camera_info";
inline constexpr const char* kMask = "camera/mask";
inline constexpr const char* kImu = "imu/data";
inline constexpr const char* kOdometry = "odom";
inline constexpr const char* kTruth = "ground_truth";
inline constexpr const char* kInitialPose = "initialpose";
}  // namespace recording_topics

/// Makes messages of a recording's moments.
class RecordingMessages {
 public:
  explicit RecordingMessages(RecordingSetup setup, RecordingFrames frames = {});

  const RecordingSetup& setup() const { return setup_; }
  const RecordingFrames& frames() const { return frames_; }

  /// bgr8 or mono8.
  sensor_msgs::ImagePtr image(const cv::Mat& color, const ros::Time& stamp) const;
  sensor_msgs::CameraInfo info(const ros::Time& stamp) const;
  /// 32FC1, metres, 0 where there is none; registered to the colour image.
  sensor_msgs::ImagePtr depth(const cv::Mat& depth, const ros::Time& stamp) const;
  sensor_msgs::ImagePtr mask(const cv::Mat& mask, const ros::Time& stamp) const;
  /// T_map_base.
  geometry_msgs::PoseStamped truth(const Pose& T_map_camera, const ros::Time& stamp) const;
  /// T_odom_base; the odometry frame is the base's where the camera's odometry is the identity.
  nav_msgs::Odometry odometry(const Pose& T_odom_camera, const ros::Time& stamp) const;
  tf2_msgs::TFMessage odometryTransform(const Pose& T_odom_camera, const ros::Time& stamp) const;
  /// base -> camera.
  tf2_msgs::TFMessage mounting(const ros::Time& stamp) const;
  geometry_msgs::PoseWithCovarianceStamped initialPose(const ros::Time& stamp) const;

 private:
  Pose baseInOdometry(const Pose& T_odom_camera) const;
  RecordingSetup setup_;
  RecordingFrames frames_;
};

}  // namespace edge_mcl
