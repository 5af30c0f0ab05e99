#include "edge_mcl/localization/tracking/focal_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace edge_mcl {

namespace {

/// The hint from which images are asked. Right calibrations have at most 0.0047 in 15 recordings
/// and flights, and wrong ones by 4 and 8 % at least 0.006.
constexpr double kHint = 0.004;
/// Errors of the focal length that are tried.
constexpr std::array<double, 3> kErrors{0.02, 0.045, 0.09};
/// The images that are asked, and the time between two of them. Neighbours show the same.
constexpr int kImages = 12;
/// The images that are asked in all, also when the hint changes its sign and questions begin anew.
constexpr int kImagesInAll = 36;
constexpr double kInterval = 0.3;  // s
/// All images asked so far must fit better, at least so many, and together so clearly (nats).
constexpr int kFewest = 5;
constexpr double kClear = 50;

/// Median depth of what the camera sees of the model, m; 0: nothing
double depthOf(const AskedImage& asked, const CameraModel& camera) {
  const Pose T_camera_map = (asked.pose * asked.T_base_camera).inverse();
  const Visibility& visibility = asked.map.visibility();
  const auto visible =
      visibility.cached(visibility.cellOf((asked.pose * asked.T_base_camera).translation()));
  std::vector<double> depths;
  for (const VisibleSet::Segment& segment : visible->segments) {
    const Eigen::Vector3d p = T_camera_map * visible->edgeSegment(segment).centre.cast<double>();
    Eigen::Vector2d pixel;
    if (p.z() > 0 && camera.project(p, &pixel) && camera.contains(pixel)) depths.push_back(p.z());
  }
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

CameraModel scaled(const CameraModel& camera, double factor) {
  CameraModel other = camera;
  other.fx *= factor;
  other.fy *= factor;
  other.validate("camera with another focal length");
  return other;
}

}  // namespace

std::optional<double> FocalCheck::look(const AskedImage& asked, const CameraModel& camera,
                                       double hint, double time) {
  if (is_done_ || std::abs(hint) < kHint) return std::nullopt;
  if (next_ && time < *next_ && time > *next_ - 2 * kInterval) return std::nullopt;
  next_ = time + kInterval;
  if (asked_ > 0 && is_longer_ != (hint > 0)) {
    asked_ = 0;
    candidates_ = {};
  }
  is_longer_ = hint > 0;
  ++asked_;
  ++asked_in_all_;
  const double fits = fitOf(asked.map, viewsOf(asked, camera), asked.pose),
               depth = depthOf(asked, camera);
  for (size_t i = 0; i < kCandidates; ++i) {
    const double factor = is_longer_ ? 1 + kErrors[i] : 1 / (1 + kErrors[i]);
    // The same things look as large from farther away.
    Pose back = Pose::Identity();
    back.translation().z() = (1 - factor) * depth;
    const Pose start = asked.pose * asked.T_base_camera * back * asked.T_base_camera.inverse();
    const std::vector<CameraView> views = viewsOf(asked, scaled(camera, factor));
    const double more =
        std::max(fitOf(asked.map, views, start), fitOf(asked.map, views, asked.pose)) - fits;
    candidates_[i].sum += more;
    candidates_[i].better += more > 0 ? 1 : 0;
  }
  const auto best =
      std::max_element(candidates_.begin(), candidates_.end(),
                       [](const Candidate& a, const Candidate& b) { return a.sum < b.sum; });
  const bool is_wrong = asked_ >= kFewest && best->better == asked_ && best->sum >= kClear;
  const bool is_right = asked_ >= kFewest && best->sum <= -kClear;
  is_done_ = is_wrong || is_right || asked_ >= kImages || asked_in_all_ >= kImagesInAll;
  if (!is_wrong) return std::nullopt;
  const double error = kErrors[static_cast<size_t>(best - candidates_.begin())];
  return is_longer_ ? 1 + error : 1 / (1 + error);
}

}  // namespace edge_mcl
