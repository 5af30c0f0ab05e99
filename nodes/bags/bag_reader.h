/// A recorded bag as input of the localizer, moment by moment, as fast as it is asked.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// Where things are in a bag; defaults are those of BagWriter.
struct BagTopics {
  std::string image = "/camera/image_raw";
  std::string camera_info = "/camera/camera_info";
  std::string mask = "/camera/mask";  ///< empty: masks are not used
  /// Empty: depth is not used.
  std::string depth = "/camera/depth/image_raw";
  std::string depth_info = "/camera/depth/camera_info";  ///< none there: the image's
  std::string truth = "/ground_truth";
  std::string initial_pose = "/initialpose";
  std::string odom_frame = "odom";  ///< empty: odometry is not used
  /// nav_msgs/Odometry, for bags whose tf has nothing between odom_frame and base_frame.
  std::string odometry = "/odom";
  std::string base_frame = "base_link";
};

class BagReader : public RecordedInput {
 public:
  /// Reads transforms, calibration, truth and the initial pose of all of the bag.
  /// @throws InputError when it is no bag, or has no image, calibration or mounting of the camera.
  BagReader(const std::string& file, BagTopics topics);
  ~BagReader() override;

  size_t imageCount() const override;
  /// T_map_base as recorded; none where there is no such message.
  const std::optional<PoseGaussian>& initialPose() const override;
  /// T_map_base.
  const Trajectory& truth() const override;
  /// The next moment; masks are those of the image's stamp, depth the nearest within 25 ms. A
  /// moment that cannot be read has no views and says why. @return false at the end.
  bool next(LiveInput* input, std::string* problem) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
