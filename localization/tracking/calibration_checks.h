/// Asks whether the images of all cameras have the calibrations that they are given with.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/localization/tracking/distortion_check.h"
#include "edge_mcl/localization/tracking/focal_check.h"

namespace edge_mcl {

/// The checks of all cameras of a robot, and what they have found. A camera is known by its
/// calibration: images of some cameras may be missing. A calibration that is no longer used (a
/// `camera_info` was corrected) is forgotten, and the new one is checked.
class CalibrationChecks {
 public:
  /// Forgets everything, e.g. because the model is another one: its wrong scale looks like a wrong
  /// focal length.
  void forget() { cameras_.clear(); }
  /// To be called with every image. @param time s
  /// @return whether an old calibration was forgotten
  bool note(const CameraModel& camera, double time);
  /// Asks an image at a trusted pose.
  /// @param hint relative error of the focal length, as the residuals tell @param time s
  /// @return what is wrong with the calibration, for people; told once. Empty: nothing
  std::string look(const AskedImage& asked, const CameraModel& camera, double hint, double time);
  /// Largest relative error of a focal length that was found; 0: none
  double focalError() const;

 private:
  struct Camera {
    CameraModel model;
    double last_seen = 0;  // s
    DistortionCheck distortion;
    FocalCheck focal;
    double focal_error = 0;
  };
  /// The checks of a camera; new ones when it is not known.
  Camera& of(const CameraModel& camera, double time);
  std::vector<Camera> cameras_;
};

}  // namespace edge_mcl
