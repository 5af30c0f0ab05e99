/// Asks images at trusted poses whether they have the focal length that their calibration tells.
#pragma once

#include <array>
#include <optional>

#include "edge_mcl/localization/tracking/camera_fit.h"

namespace edge_mcl {

/// A calibration of another resolution or lens, or from a data sheet, has a focal length that is
/// off by several hundredths. The pose then is off by this share of the distance to what the images
/// show, and nothing else tells it. The residuals of the lines give a hint of the error
/// (UpdateReport::focal_error). It is too small, since edges that are far off do not count. So
/// where there is a hint, each of some images is compared with the model with other focal lengths
/// as well.
class FocalCheck {
 public:
  /// @param hint relative error of the focal length, as the residuals tell
  /// @param time s
  /// @return once: the factor on the focal length with which the images fit clearly better
  std::optional<double> look(const AskedImage& asked, const CameraModel& camera, double hint,
                             double time);

 private:
  static constexpr size_t kCandidates = 3;
  struct Candidate {
    int better = 0;  // images
    double sum = 0;  // of what the images fit better, nats
  };
  int asked_ = 0;         // images, since the hint has this sign
  int asked_in_all_ = 0;  // images
  bool is_longer_ = false;
  std::array<Candidate, kCandidates> candidates_;
  std::optional<double> next_;  // time of the next question, s
  bool is_done_ = false;
};

}  // namespace edge_mcl
