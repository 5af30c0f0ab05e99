#include "edge_mcl/localization/objects/object_names.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edge_mcl {

namespace {

constexpr double kMemory = 2;       // s
constexpr double kSameTime = 0.02;  // s; less than an image at 30 Hz
/// Overlap of the boxes (intersection over union) from which they belong to one object. The box of
/// a network holds the parts that depth does not see, such as feet.
constexpr double kOverlap = 0.3;
/// Sum of scores from which a name is given: one image proves little.
constexpr double kSure = 1;

/// The part of the image that shows a box; empty when a corner is beside or behind the camera.
cv::Rect2d boxInImage(const CameraModel& camera, const Pose& T_map_camera,
                      const Eigen::AlignedBox3d& box) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  Eigen::Vector2d low(kInf, kInf), high(-kInf, -kInf);
  const Pose T_camera_map = T_map_camera.inverse();
  for (int i = 0; i < 8; ++i) {
    Eigen::Vector2d pixel;
    const auto corner = static_cast<Eigen::AlignedBox3d::CornerType>(i);
    if (!camera.project(T_camera_map * box.corner(corner), &pixel)) return {};
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  }
  const cv::Rect2d whole(0, 0, camera.width, camera.height);
  return cv::Rect2d(low.x(), low.y(), high.x() - low.x(), high.y() - low.y()) & whole;
}

double overlapOf(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double common = (a & b).area(), all = a.area() + b.area() - common;
  return all > 0 ? common / all : 0;
}

}  // namespace

void ObjectNames::remember(double time, const CameraModel& camera, const Pose& T_map_camera,
                           const std::vector<ObjectState>& objects) {
  if (!seen_.empty() && time < seen_.back().time) seen_.clear();
  while (!seen_.empty() && seen_.front().time < time - kMemory) seen_.pop_front();
  Seen seen{time, {}};
  for (const ObjectState& object : objects)
    if (object.is_in_view) seen.boxes[object.number] = boxInImage(camera, T_map_camera, object.box);
  seen_.push_back(std::move(seen));
  // Numbers are not used twice.
  constexpr size_t kMost = 1000;
  while (scores_.size() > kMost) scores_.erase(scores_.begin());
}

void ObjectNames::hear(double time, const std::vector<Found>& found) {
  const auto seen = std::find_if(seen_.begin(), seen_.end(), [&](const Seen& s) {
    return std::abs(s.time - time) < kSameTime;
  });
  if (seen == seen_.end()) return;
  for (const Found& f : found) {
    const auto best =
        std::max_element(seen->boxes.begin(), seen->boxes.end(), [&](const auto& a, const auto& b) {
          return overlapOf(a.second, f.box) < overlapOf(b.second, f.box);
        });
    if (best != seen->boxes.end() && overlapOf(best->second, f.box) >= kOverlap)
      scores_[best->first][f.name] += f.score;
  }
}

std::string ObjectNames::nameOf(int number) const {
  const auto known = scores_.find(number);
  if (known == scores_.end()) return "";
  const auto best =
      std::max_element(known->second.begin(), known->second.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return best->second >= kSure ? best->first : "";
}

}  // namespace edge_mcl
