#include "edge_mcl/localization/tracking/calibration_checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace edge_mcl {

namespace {

/// A driver whose lens focuses by itself tells a slightly different focal length with every image.
/// A smaller change than this share is no other calibration. The same number of pixels holds for
/// the principal point.
constexpr double kSameFocalLength = 0.005;

constexpr char kNoDistortionInImages[] =
    "images fit the model better without the distortion of their calibration; if they are "
    "rectified, give a calibration without distortion (a bag, or the node: rectified=true)";

/// @param factor with which the images fit better
std::string otherFocalLength(const CameraModel& camera, double factor) {
  char text[256];
  std::snprintf(text, sizeof text,
                "images fit the model better with a focal length of about %.0f pixels than with "
                "%.0f as calibrated; positions are off by about %.0f %% of the distance to what is "
                "seen; calibrate the camera at this resolution, or check the scale of the model",
                factor * camera.fx, camera.fx, 100 * std::abs(factor - 1));
  return text;
}

bool isSame(const CameraModel& a, const CameraModel& b) {
  const double most = kSameFocalLength * a.fx;
  return a.width == b.width && a.height == b.height && a.distortion == b.distortion &&
         a.coefficients == b.coefficients && std::abs(a.fx - b.fx) <= most &&
         std::abs(a.fy - b.fy) <= most && std::abs(a.cx - b.cx) <= most &&
         std::abs(a.cy - b.cy) <= most;
}

}  // namespace

CalibrationChecks::Camera& CalibrationChecks::of(const CameraModel& camera, double time) {
  for (Camera& known : cameras_)
    if (isSame(known.model, camera)) {
      known.last_seen = time;
      return known;
    }
  cameras_.push_back({camera, time, {}, {}, 0});
  return cameras_.back();
}

bool CalibrationChecks::note(const CameraModel& camera, double time) {
  constexpr double kUnused = 3;  // s; the images of a camera may be missing for a while
  of(camera, time);
  const auto unused = std::remove_if(cameras_.begin(), cameras_.end(), [&](const Camera& known) {
    return std::abs(time - known.last_seen) > kUnused;
  });
  const bool forgets = unused != cameras_.end();
  cameras_.erase(unused, cameras_.end());
  return forgets;
}

std::string CalibrationChecks::look(const AskedImage& asked, const CameraModel& camera, double hint,
                                    double time) {
  Camera& checked = of(camera, time);
  if (checked.distortion.look(asked, camera, time)) return kNoDistortionInImages;
  const auto factor = checked.focal.look(asked, camera, hint, time);
  if (!factor) return "";
  checked.focal_error = *factor - 1;
  return otherFocalLength(camera, *factor);
}

double CalibrationChecks::focalError() const {
  double largest = 0;
  for (const Camera& camera : cameras_)
    if (std::abs(camera.focal_error) > std::abs(largest)) largest = camera.focal_error;
  return largest;
}

}  // namespace edge_mcl
