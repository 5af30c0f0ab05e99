#include "edge_mcl/localization/tracking/distortion_check.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

namespace {

/// The images that are asked, and the time between two of them. Neighbours show the same.
constexpr int kImages = 10;
constexpr double kInterval = 0.3;  // s
/// All of the images asked so far must be straight, at least so many, and together so clearly
/// (nats). Flights whose corners move by 16 and 33 pixels have 140 after five images, and -120 or
/// less when the images do have the distortion.
constexpr int kFewest = 5;
constexpr double kClear = 50;
/// A distortion that moves no pixel by more cannot be told from the noise of edges.
constexpr double kVisible = 1.5;  // pixels

/// How far the distortion moves the corners of an image, pixels.
double largestShift(const CameraModel& camera, const CameraModel& straight) {
  double largest = 0;
  for (const double u : {0.0, camera.width - 1.0})
    for (const double v : {0.0, camera.height - 1.0}) {
      const Eigen::Vector3d ray((u - straight.cx) / straight.fx, (v - straight.cy) / straight.fy,
                                1);
      Eigen::Vector2d pixel;
      // A corner that the distorted lens does not see at all is far enough away.
      const double shift =
          camera.project(ray, &pixel) ? (pixel - Eigen::Vector2d(u, v)).norm() : camera.width;
      largest = std::max(largest, shift);
    }
  return largest;
}

}  // namespace

bool DistortionCheck::look(const AskedImage& asked, const CameraModel& camera, double time) {
  if (asked_ >= kImages || camera.distortion == DistortionModel::kNone) return false;
  if (next_ && time < *next_ && time > *next_ - 2 * kInterval) return false;
  next_ = time + kInterval;
  CameraModel straight = camera;
  straight.distortion = DistortionModel::kNone;
  straight.coefficients = {};
  straight.validate("camera without distortion");
  if (largestShift(camera, straight) < kVisible) {
    asked_ = kImages;
    return false;
  }
  const auto fit = [&](const CameraModel& model) {
    return fitOf(asked.map, viewsOf(asked, model), asked.pose);
  };
  const double more = fit(straight) - fit(camera);
  ++asked_;
  sum_ += more;
  straight_ += more > 0 ? 1 : 0;
  const bool is_straight = asked_ >= kFewest && straight_ == asked_ && sum_ >= kClear;
  const bool is_bent = asked_ >= kFewest && sum_ <= -kClear;
  if (is_straight || is_bent) asked_ = kImages;
  return is_straight;
}

}  // namespace edge_mcl
