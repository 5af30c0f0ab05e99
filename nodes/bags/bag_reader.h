/// Reads a ROS bag as input of the localizer, moment by moment, without a clock.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// Names of topics and frames in a bag. The defaults are the names that BagWriter writes.
struct BagTopics {
  std::string image = "/camera/image_raw";
  std::string camera_info = "/camera/camera_info";
  std::string mask = "/camera/mask";  ///< empty: masks are not used
  /// Topic of the depth images. Empty: depth is not used.
  std::string depth = "/camera/depth/image_raw";
  std::string depth_info = "/camera/depth/camera_info";  ///< without messages: camera_info
  std::string truth = "/ground_truth";
  std::string initial_pose = "/initialpose";
  std::string odom_frame = "odom";  ///< empty: odometry is not used
  /// Topic of nav_msgs/Odometry. It is used when tf has no transform from odom_frame to base_frame.
  std::string odometry = "/odom";
  std::string base_frame = "base_link";
};

/// A bag as a recording. One image makes one moment.
class BagReader : public RecordedInput {
 public:
  /// Opens a bag and reads its transforms, calibration, ground truth and initial pose.
  /// @throws InputError when the file is not a bag, or has no images or no calibration
  BagReader(const std::string& file, BagTopics topics);
  ~BagReader() override;

  size_t imageCount() const override;
  /// T_map_base of the first message on `initial_pose`; none if there is no message.
  const std::optional<PoseGaussian>& initialPose() const override;
  /// Ground truth, T_map_base; empty if the bag has none.
  const Trajectory& truth() const override;
  /// Reads the next image with its mask (of the same stamp), its depth image (the nearest within 25
  /// ms) and its odometry. Data that cannot be read are left out, and `problem` says why.
  /// @return false at the end of the bag
  bool next(LiveInput* input, std::string* problem) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
