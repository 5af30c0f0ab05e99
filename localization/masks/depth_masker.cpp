#include "edge_mcl/localization/masks/depth_masker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edge_mcl {

namespace {

/// Pixels around a foreign point in an image 640 pixels wide, for what colour and depth camera see
/// beside each other. image.mask_dilation adds the reach of the image's smoothing.
constexpr double kMargin = 1, kMarginWidth = 640;
/// Growth of a mask, as a share of the image, above which it is held back. A person who walks by
/// at 2 m needs several images at 10 Hz to cover as much.
constexpr double kGrowth = 0.25;
/// Largest share of the image that is masked by depth. People and furniture covered at most 0.48 of
/// simulated flights. More is a wrong scale or mounting of the depth camera.
constexpr double kMost = 0.6;

/// Sets the pixels around the points of a depth sensor.
void paint(const DepthMasker::Foreign& sensor, const std::vector<Eigen::Vector3f>& points,
           const CameraModel& camera, const Pose& T_base_camera, uint8_t value, cv::Mat* mask) {
  const Pose T_camera_depth = T_base_camera.inverse() * sensor.T_base_depth;
  const double enlarged = std::max(camera.fx, camera.fy) / std::max(sensor.focal_length, 1.0);
  const int reach = static_cast<int>(
      std::ceil(sensor.points.spacing * enlarged / 2 + kMargin * camera.width / kMarginWidth));
  const cv::Rect whole({0, 0}, mask->size());
  for (const Eigen::Vector3f& point : points) {
    Eigen::Vector2d pixel;
    if (!camera.project(T_camera_depth * point.cast<double>(), &pixel) || !camera.contains(pixel))
      continue;
    const int x = static_cast<int>(std::lround(pixel.x())),
              y = static_cast<int>(std::lround(pixel.y()));
    const cv::Rect square(x - reach, y - reach, 2 * reach + 1, 2 * reach + 1);
    (*mask)(square & whole).setTo(value);
  }
}

}  // namespace

Cues neededImages(const Parameters& params) {
  const bool needs_both = params.likelihood.cues == Cues::kEdges && params.tracking.mask_by_depth;
  return needs_both ? Cues::kBoth : params.likelihood.cues;
}

DepthMasker::Foreign DepthMasker::find(const LocalizationMap& map, const DepthImage& image,
                                       const PoseGaussian& T_map_base, const Pose& T_base_depth,
                                       bool lists_model) {
  Foreign foreign;
  foreign.T_base_depth = T_base_depth;
  foreign.focal_length = std::max(image.camera.fx, image.camera.fy);
  const RayScene* scene = map.visibility().scene();
  if (!scene) return foreign;
  PoseGaussian T_map_depth;
  T_map_depth.mean = T_map_base.mean * T_base_depth;
  const Matrix6 to_depth = adjoint(T_base_depth.inverse());
  T_map_depth.covariance = to_depth * T_map_base.covariance * to_depth.transpose();
  foreign.points = foreignPoints(image, *scene, T_map_depth, map.params().depth,
                                 map.params().tracking.mask_by_depth_from, lists_model);
  return foreign;
}

cv::Mat DepthMasker::add(size_t view, const std::vector<Foreign>& foreign,
                         const CameraModel& camera, const Pose& T_base_camera, double most,
                         const cv::Mat& mask) {
  const cv::Size size(camera.width, camera.height);
  if (foreign.empty()) return mask;
  if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != size)) return mask;
  cv::Mat found(size, CV_8U, cv::Scalar(0));
  for (const Foreign& f : foreign) paint(f, f.points.points, camera, T_base_camera, 255, &found);
  const double share = cv::countNonZero(found) / static_cast<double>(found.total());
  const auto before = shares_.find(view);
  // The first mask is held back as well when it is large.
  const bool is_held_back =
      share > kMost || share > kGrowth + (before == shares_.end() ? 0 : before->second);
  shares_[view] = share;
  if (is_held_back || (share == 0 && mask.empty())) return mask;
  if (!mask.empty()) {
    cv::Mat others = mask.clone();
    for (const Foreign& f : foreign) paint(f, f.points.of_model, camera, T_base_camera, 0, &others);
    cv::bitwise_or(found, others, found);
  }
  return cv::countNonZero(found) > most * static_cast<double>(found.total()) ? mask : found;
}

}  // namespace edge_mcl
