/// Reads a ROS bag as input of the localizer, moment by moment, without a clock.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// Names of topics and frames in a bag. The defaults are the names that BagWriter writes. A topic
/// of images may hold compressed images, or its compressed form may be in the bag in its place.
struct BagTopics {
  std::string image = "/camera/image_raw";
  std::string camera_info;            ///< empty: camera_info beside the images
  std::string mask = "/camera/mask";  ///< empty: masks are not used
  /// Topic of the depth images. Empty: depth is not used.
  std::string depth = "/camera/depth/image_raw";
  /// Empty: camera_info beside the depth images. Without messages the calibration of the images
  /// counts.
  std::string depth_info;
  std::string truth = "/ground_truth";
  std::string initial_pose = "/initialpose";
  std::string odom_frame = "odom";  ///< empty: odometry is not used
  /// Topic of nav_msgs/Odometry. It is used when tf has no transform from odom_frame to base_frame.
  std::string odometry = "/odom";
  std::string base_frame = "base_link";
  std::string camera_frame;        ///< optical frame of the camera; empty: that of the images
  std::string rectified = "auto";  ///< true, false, or auto: the topic has rect in its name
};

/// A bag as a recording. One image makes one moment.
class BagReader : public RecordedInput {
 public:
  /// Opens the bags of a recording and reads their transforms, calibration, ground truth and
  /// initial pose.
  /// @param camera calibration; none: that of the bag.
  /// @throws InputError when a file is not a bag, or when there are no images or no calibration
  BagReader(const std::vector<std::string>& files, BagTopics topics,
            const std::optional<CameraModel>& camera = std::nullopt);
  ~BagReader() override;

  size_t imageCount() const override;
  /// T_map_base of the first message on `initial_pose`; none if there is no message.
  const std::optional<PoseGaussian>& initialPose() const override;
  /// Ground truth, T_map_base; empty if the bag has none.
  const Trajectory& truth() const override;
  std::vector<std::string> notes() const override;
  /// Whether there are messages on the topic of depth images.
  bool hasDepth() const;
  /// Reads the next image with its mask (of the same stamp), its depth image (the nearest within 25
  /// ms) and its odometry. Data that cannot be read are left out, and `problem` says why.
  /// @return false at the end of the bag
  bool next(LiveInput* input, std::string* problem) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
