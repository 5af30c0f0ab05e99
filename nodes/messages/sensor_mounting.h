/// Where a sensor is on the robot, by tf and odometry.
#pragma once

#include <ros/time.h>
#include <std_msgs/Header.h>
#include <tf2/buffer_core.h>

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// T_base_sensor at the time of the message, since a gimbal turns. Where tf does not know that
/// time, the newest transform counts.
/// @param origin named in errors. @throws InputError when tf does not know the frames
Pose sensorMounting(const tf2::BufferCore& transforms, const std::string& base_frame,
                    const std_msgs::Header& header, const std::string& origin);

/// Where the cameras are on the robot, for recordings and robots with and without tf.
///
/// Images that name no frame get the only frame of tf that is called an optical one. The camera
/// itself is localized, as if it were the base, when there is no such frame, or when tf does not
/// know the base. Odometry does not belong to the camera then, and must not be used.
class CameraMounting {
 public:
  /// @param patience s by the wall clock, from the first question on, until tf must know the base.
  CameraMounting(const std::string& base_frame, double patience);

  /// T_base_camera. @param frame the optical frame; empty: that of the header.
  /// @throws InputError when tf knows the base but not the camera
  Pose of(const tf2::BufferCore& transforms, const std_msgs::Header& header,
          const std::string& frame, const std::string& origin);
  /// Whether the camera is the base.
  bool isBase() const { return is_base_; }
  /// What the user should know, in one line each, told once.
  std::vector<std::string> takeNotes();

 private:
  void becomeBase(const std::string& why);

  const std::string base_frame_;
  const ros::WallDuration patience_;
  std::optional<ros::WallTime> asked_;
  std::atomic<bool> is_base_{false};  // may be asked for by another thread
  bool is_axis_told_ = false, is_guess_told_ = false;
  std::string frame_of_nameless_;  // taken for images without a frame
  std::vector<std::string> notes_;
};

/// Whether a camera frame seems to have the axes of a body (x ahead, z up) and not those of an
/// optical frame (z ahead, y down).
bool hasBodyAxes(const Pose& T_base_camera);

/// T_moment_stamp of the base by odometry: how the robot moved from one time to the other. Identity
/// when the times are the same, more than a second apart, or not both known to odometry.
Pose baseMotion(const tf2::BufferCore& odometry, const std::string& odom_frame,
                const std::string& base_frame, const ros::Time& moment, const ros::Time& stamp);

}  // namespace edge_mcl
