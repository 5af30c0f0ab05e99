/// Converts recorded moments to the messages that a robot would publish.
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

/// Names of the frames in the messages, as in REP 105.
struct RecordingFrames {
  std::string map = "map", odom = "odom", base = "base_link", camera = "camera_optical";
};

/// Names of the topics, relative to a namespace.
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

/// Makes the messages of a recording.
class RecordingMessages {
 public:
  explicit RecordingMessages(RecordingSetup setup, RecordingFrames frames = {});

  const RecordingSetup& setup() const { return setup_; }
  const RecordingFrames& frames() const { return frames_; }

  /// Colour or grey image of 8 or 16 bits, with one, three or four channels (e.g. bgr8, mono8).
  /// @throws InputError for any other type
  sensor_msgs::ImagePtr image(const cv::Mat& color, const ros::Time& stamp) const;
  sensor_msgs::CameraInfo info(const ros::Time& stamp) const;
  /// Depth image, 32FC1, metres, registered to the colour image; 0: no depth. @param depth in units
  /// of the recording (RecordingSetup::depth_scale).
  sensor_msgs::ImagePtr depth(const cv::Mat& depth, const ros::Time& stamp) const;
  /// Mask, mono8; non-zero: not in the map.
  sensor_msgs::ImagePtr mask(const cv::Mat& mask, const ros::Time& stamp) const;
  /// Ground truth of the base, T_map_base.
  geometry_msgs::PoseStamped truth(const Pose& T_map_camera, const ros::Time& stamp) const;
  /// Odometry of the base, T_odom_base. The odometry frame is the frame of the base at the moment
  /// at which T_odom_camera is the identity.
  nav_msgs::Odometry odometry(const Pose& T_odom_camera, const ros::Time& stamp) const;
  /// The same pose as a transform odom -> base.
  tf2_msgs::TFMessage odometryTransform(const Pose& T_odom_camera, const ros::Time& stamp) const;
  /// Extrinsics of the camera, as a transform base -> camera.
  tf2_msgs::TFMessage mounting(const ros::Time& stamp) const;
  /// Initial pose of the base, T_map_base, with its covariance.
  geometry_msgs::PoseWithCovarianceStamped initialPose(const ros::Time& stamp) const;

 private:
  Pose baseInOdometry(const Pose& T_odom_camera) const;
  RecordingSetup setup_;
  RecordingFrames frames_;
};

}  // namespace edge_mcl
