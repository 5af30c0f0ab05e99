#include "edge_mcl/localization/objects/object_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace edge_mcl {

namespace {

/// Least depth of an object as a share of its width, and the largest that is only guessed: people,
/// chairs and boxes. 1, m
constexpr double kDepthOfWidth = 0.7, kMostGuessed = 0.6;
/// A size grows and shrinks by these shares of the difference in every image. It grows faster: an
/// object is often covered, and never larger than it is.
constexpr double kGrow = 0.5, kShrink = 0.05;
/// Depths that differ by so much more than expected are another thing in front, m.
constexpr double kInFront = 0.5;
/// Bins of the hue, the saturation (both only where there is colour) and the brightness.
constexpr int kHues = 12, kBrightnesses = 8;
constexpr int kLeastSaturation = 40;  // of 255

Eigen::Vector3d horizontal(const Eigen::Vector3d& direction, const Eigen::Vector3d& otherwise) {
  const Eigen::Vector3d flat(direction.x(), direction.y(), 0);
  return flat.norm() > 1e-6 ? Eigen::Vector3d(flat.normalized()) : otherwise;
}

}  // namespace

ObjectSide::ObjectSide(const PointCluster& cluster, const ForeignDepth& view)
    : eye_(view.T_map_depth.translation()) {
  const Eigen::AlignedBox3d box = boxOf(cluster);
  forward_ = horizontal(box.center() - eye_, Eigen::Vector3d::UnitX());
  right_ = forward_.cross(Eigen::Vector3d::UnitZ());
  // The same trimming as that of the box, in the axes of the view.
  Eigen::Matrix3d to_view;
  to_view << right_.transpose(), forward_.transpose(), Eigen::Vector3d::UnitZ().transpose();
  PointCluster turned = cluster;
  for (VoxelPoint& v : turned) v.point = (to_view * (v.point.cast<double>() - eye_)).cast<float>();
  const Eigen::AlignedBox3d seen = boxOf(turned);
  left_end_ = seen.min().x();
  right_end_ = seen.max().x();
  near_ = seen.min().y();
  far_ = seen.max().y();
  low_ = seen.min().z();
  high_ = seen.max().z();
  const CameraModel& camera = view.image.camera;
  const double margin = 2 * view.foreign.spacing + 1;
  const Pose T_depth_map = view.T_map_depth.inverse();
  for (const VoxelPoint& v : cluster) {
    Eigen::Vector2d pixel;
    if (!camera.project(T_depth_map * v.point.cast<double>(), &pixel)) continue;
    cut_left_ |= pixel.x() < margin;
    cut_right_ |= pixel.x() > camera.width - 1 - margin;
    cut_above_ |= pixel.y() < margin;
    cut_below_ |= pixel.y() > camera.height - 1 - margin;
  }
}

Eigen::Vector3d ObjectSide::middle(const SeenSize& size) const {
  double across = (left_end_ + right_end_) / 2;
  if (cut_left_ && !cut_right_) across = right_end_ - size[0] / 2;
  if (cut_right_ && !cut_left_) across = left_end_ + size[0] / 2;
  double up = (low_ + high_) / 2;
  if (cut_below_ && !cut_above_) up = high_ - size[2] / 2;
  if (cut_above_ && !cut_below_) up = low_ + size[2] / 2;
  return eye_ + across * right_ + (near_ + size[1] / 2) * forward_ + up * Eigen::Vector3d::UnitZ();
}

Eigen::AlignedBox3d ObjectSide::boxAround(const Eigen::Vector3d& middle,
                                          const SeenSize& size) const {
  const Eigen::Vector3d half = (right_.cwiseAbs() * size[0] + forward_.cwiseAbs() * size[1] +
                                Eigen::Vector3d::UnitZ() * size[2]) /
                               2;
  return {middle - half, middle + half};
}

SeenSize ObjectSide::learn(const std::optional<SeenSize>& before) const {
  const double width = right_end_ - left_end_;
  SeenSize seen(width, std::max(far_ - near_, std::min(kDepthOfWidth * width, kMostGuessed)),
                high_ - low_);
  if (!before) return seen;
  const std::array<bool, 3> is_cut{cut_left_ || cut_right_, false, cut_above_ || cut_below_};
  SeenSize size = *before;
  for (int axis = 0; axis < 3; ++axis) {
    const double more = seen[axis] - size[axis];
    if (more > 0)
      size[axis] += kGrow * more;
    else if (!is_cut[static_cast<size_t>(axis)])
      size[axis] += kShrink * more;
  }
  return size;
}

Sight lookAt(const ForeignDepth& view, const Eigen::Vector3d& point, double tolerance,
             const DepthParameters& params) {
  const Eigen::Vector3d seen = view.T_map_depth.inverse() * point;
  Eigen::Vector2d pixel;
  const CameraModel& camera = view.image.camera;
  if (!(seen.z() > 0) || !camera.project(seen, &pixel) || !camera.contains(pixel)) return {};
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, camera.width - 1),
            y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, camera.height - 1);
  const double depth = metresAt(view.image, x, y);
  if (!(depth > 0)) return {};
  const double noise = 3 * std::hypot(params.sigma, params.sigma_per_square_metre * depth * depth);
  Sight sight;
  sight.surface = view.T_map_depth * (depth / seen.z() * seen);
  sight.kind = Sight::Kind::kThere;
  if (depth > seen.z() + tolerance + noise) sight.kind = Sight::Kind::kFree;
  if (depth < seen.z() - kInFront) sight.kind = Sight::Kind::kHidden;
  return sight;
}

Appearance appearanceOf(const PointCluster& cluster, const ForeignColour& view) {
  if (view.image.empty() || (view.image.type() != CV_8UC3 && view.image.type() != CV_8UC1))
    return {};
  const bool is_grey = view.image.type() == CV_8UC1;
  const Pose T_camera_map = view.T_map_camera.inverse();
  std::vector<cv::Vec3b> colours;
  for (const VoxelPoint& v : cluster) {
    Eigen::Vector2d pixel;
    const Eigen::Vector3d seen = T_camera_map * v.point.cast<double>();
    if (!view.camera.project(seen, &pixel) || !view.camera.contains(pixel)) continue;
    const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
    if (x >= view.image.cols || y >= view.image.rows) continue;
    colours.push_back(is_grey ? cv::Vec3b::all(view.image.at<uint8_t>(y, x))
                              : view.image.at<cv::Vec3b>(y, x));
  }
  if (colours.empty()) return {};
  cv::cvtColor(colours, colours, cv::COLOR_BGR2HSV);
  Appearance appearance(kHues + kBrightnesses, 0);
  const float share = 1 / static_cast<float>(colours.size());
  for (const cv::Vec3b& c : colours)  // OpenCV's hues are 0 to 179
    appearance[static_cast<size_t>(
        c[1] >= kLeastSaturation ? c[0] * kHues / 180 : kHues + c[2] * kBrightnesses / 256)] +=
        share;
  return appearance;
}

double differenceOf(const Appearance& a, const Appearance& b) {
  if (a.empty() || b.empty()) return 0;
  double common = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    common += std::sqrt(static_cast<double>(a[i] * b[i]));
  return std::sqrt(std::max(0.0, 1 - common));
}

}  // namespace edge_mcl
