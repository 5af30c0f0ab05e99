/// Turns the messages of a moment into input of the localizer.
#pragma once

#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/nodes/localizer/imu_history.h"
#include "edge_mcl/nodes/localizer/moment_queue.h"
#include "edge_mcl/nodes/messages/sensor_mounting.h"

namespace edge_mcl {

/// A moment as the localizer takes it.
struct MomentInput {
  LiveInput input;
  double mask_age = -1;  ///< s between image and mask; negative: there is no mask
  std::string problem;   ///< why something is missing, one line; empty: nothing is
};

/// Adds odometry (tf or topic), the mounting of the sensors (tf), roll and pitch (IMU) and masks.
/// `read` is for one thread; the other functions may be called from any.
class MomentReader {
 public:
  MomentReader(const ros::NodeHandle& nh, const NodeParameters& params, Cues cues,
               size_t camera_count);

  /// Waits for odometry of the moment for as long as the parameters say.
  MomentInput read(const Moment& moment);
  /// Keeps odometry of a topic. @throws InputError when the message is not valid
  void addOdometry(const nav_msgs::Odometry& odometry);
  const tf2_ros::Buffer& transforms() const { return tf_; }
  /// Whether the camera is localized itself, see CameraMounting.
  bool isCameraBase() const { return mounting_.isBase(); }
  /// Ends all waiting.
  void stop() { running_ = false; }

 private:
  /// The mask that was used last, for `mask_policy` use_last.
  struct LastMask {
    cv::Mat mask;
    ros::Time stamp;
    std::optional<Eigen::Matrix3d> R_odom_camera;
  };

  const tf2::BufferCore& odometryBuffer() const {
    const tf2::BufferCore& of_tf = tf_;
    return odometry_buffer_ ? *odometry_buffer_ : of_tf;
  }
  /// @param latest the wait goes on until odometry knows this time as well, but not longer than the
  /// parameters say
  std::optional<Pose> odometryAt(const ros::Time& stamp, const ros::Time& latest,
                                 std::string* problem);
  std::optional<UpReading> upAt(const ros::Time& stamp, std::string* problem);
  /// Pose of a sensor relative to the base of the moment. The robot moves on between the stamps of
  /// its sensors.
  /// @param frame of the sensor; empty: that of the header.
  Pose mountingOf(const std_msgs::Header& header, const std::string& frame,
                  const std::string& origin, const ros::Time& moment);
  /// @throws InputError when the view cannot be used
  void addView(const Moment::CameraPart& part, const ros::Time& moment, LastMask* last,
               MomentInput* result);
  /// @throws InputError when the depth image cannot be used
  void addDepth(const Moment::CameraPart& part, const ros::Time& moment, size_t camera,
                LastMask* last, MomentInput* result);
  /// The mask of an image by `mask_policy`; empty: none. @throws InputError when the policy is to
  /// skip the image
  cv::Mat maskFor(const Moment::CameraPart& part, const CameraModel& model,
                  const Pose& T_base_camera, LastMask* last, MomentInput* result) const;

  const NodeParameters params_;
  const Cues cues_;
  tf2_ros::Buffer tf_;
  tf2_ros::TransformListener tf_listener_;
  std::unique_ptr<tf2::BufferCore> odometry_buffer_;  // of the topic; null: odometry is in tf
  ros::Time odometry_at_;                             // stamp of the newest on the topic
  Patience odometry_patience_, sensors_patience_;
  ImuHistory imu_;
  ros::Subscriber imu_subscriber_;
  CameraMounting mounting_;
  std::vector<LastMask> last_masks_;  // by camera
  std::atomic<bool> running_{true};
};

}  // namespace edge_mcl
