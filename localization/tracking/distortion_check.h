/// Asks images at trusted poses whether they have the distortion that their calibration tells.
#pragma once

#include <optional>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// Rectified images beside the calibration of the raw ones are a common mistake. Straight edges of
/// the model are then bent where those of the image are straight, and the pose is off by several
/// centimetres. So each of some images is compared with the model twice, with and without the
/// distortion.
class DistortionCheck {
 public:
  /// @param image,mask as LocalizationMap::prepare() takes them
  /// @param pose T_map_base, a pose that is trusted
  /// @param time s
  /// @return true once: the images fit clearly better without the distortion
  bool look(const LocalizationMap& map, const CameraModel& camera, const cv::Mat& image,
            const cv::Mat& mask, const Pose& T_base_camera, const Pose& pose, double time);

 private:
  /// By how much an image fits better without the distortion, nats.
  static double advantage(const LocalizationMap& map, const CameraModel& camera,
                          const CameraModel& straight, const cv::Mat& image, const cv::Mat& mask,
                          const Pose& T_base_camera, const Pose& pose);

  int asked_ = 0, straight_ = 0;  // images
  double sum_ = 0;                // of advantages, nats
  std::optional<double> next_;    // time of the next question, s
};

}  // namespace edge_mcl
