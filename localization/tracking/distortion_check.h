/// Asks images at trusted poses whether they have the distortion that their calibration tells.
#pragma once

#include <optional>

#include "edge_mcl/localization/tracking/camera_fit.h"

namespace edge_mcl {

/// Rectified images beside the calibration of the raw ones are a common mistake. Straight edges of
/// the model are then bent where those of the image are straight, and the pose is off by several
/// centimetres. So each of some images is compared with the model twice, with and without the
/// distortion.
class DistortionCheck {
 public:
  /// @param time s
  /// @return true once: the images fit clearly better without the distortion
  bool look(const AskedImage& asked, const CameraModel& camera, double time);

 private:
  int asked_ = 0, straight_ = 0;  // images
  double sum_ = 0;                // of advantages, nats
  std::optional<double> next_;    // time of the next question, s
};

}  // namespace edge_mcl
