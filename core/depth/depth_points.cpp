#include "edge_mcl/core/depth/depth_points.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/camera_rays.h"

namespace edge_mcl {

void checkDepth(const DepthImage& image) {
  const auto sizeOf = [](int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
  };
  const cv::Mat& d = image.depth;
  if (d.type() != CV_16UC1 && d.type() != CV_32FC1)
    throw InputError(image.origin + ": a depth image has one channel of 16 bits or of floats");
  if (d.cols != image.camera.width || d.rows != image.camera.height)
    throw InputError(image.origin + ": the depth image has " + sizeOf(d.cols, d.rows) +
                     " pixels, its camera " + sizeOf(image.camera.width, image.camera.height));
  if (!image.mask || image.mask->pixels.empty()) return;
  const cv::Mat& m = image.mask->pixels;
  if (m.type() != CV_8UC1) throw InputError(image.origin + ": a mask has one channel of 8 bits");
  if (m.cols != image.mask->camera.width || m.rows != image.mask->camera.height)
    throw InputError(image.origin + ": the mask has " + sizeOf(m.cols, m.rows) +
                     " pixels, its camera " +
                     sizeOf(image.mask->camera.width, image.mask->camera.height));
}

double metresAt(const DepthImage& image, int x, int y) {
  if (image.depth.type() == CV_16UC1) return image.depth.at<uint16_t>(y, x) / image.units_per_metre;
  const double metres = image.depth.at<float>(y, x);
  return std::isfinite(metres) ? metres : 0;
}

namespace {

bool isIgnored(const DepthImage& image, const Eigen::Vector3d& point) {
  if (!image.mask || image.mask->pixels.empty()) return false;
  Eigen::Vector2d pixel;
  if (!image.mask->camera.project(image.mask->T_mask_depth * point, &pixel) ||
      !image.mask->camera.contains(pixel))
    return false;
  return image.mask->pixels.at<uint8_t>(static_cast<int>(std::lround(pixel.y())),
                                        static_cast<int>(std::lround(pixel.x()))) != 0;
}

}  // namespace

DepthPoints makeDepthPoints(const DepthImage& image, const DepthParameters& params) {
  checkDepth(image);
  const CameraModel& camera = image.camera;
  // Four times as many pixels as wanted are examined, because some have no depth.
  const double area = static_cast<double>(camera.width) * camera.height;
  const int step = std::max(1, static_cast<int>(std::sqrt(area / (4.0 * params.points))));
  std::vector<Eigen::Vector3d> found;
  size_t looked_at = 0;
  for (int y = step / 2; y < camera.height; y += step)
    for (int x = step / 2; x < camera.width; x += step) {
      const double depth = metresAt(image, x, y);
      const bool in_range = depth > 0 && depth >= params.min_range && depth <= params.max_range;
      Eigen::Vector2d ray;
      if (in_range && !unproject(camera, {x, y}, &ray)) continue;
      const Eigen::Vector3d point = depth * Eigen::Vector3d(ray.x(), ray.y(), 1);
      if (in_range && isIgnored(image, point)) continue;
      ++looked_at;
      if (in_range) found.push_back(point);
    }
  DepthPoints points;
  if (found.empty()) return points;
  points.returned = static_cast<double>(found.size()) / static_cast<double>(looked_at);
  points.count = std::min(found.size(), static_cast<size_t>(params.points));
  const size_t padded =
      (points.count + DepthPoints::kPadding - 1) / DepthPoints::kPadding * DepthPoints::kPadding;
  for (std::vector<float>* v : {&points.x, &points.y, &points.z, &points.inverse_variance})
    v->assign(padded, 0);
  for (size_t i = 0; i < points.count; ++i) {
    const Eigen::Vector3d& p = found[i * found.size() / points.count];
    points.x[i] = static_cast<float>(p.x());
    points.y[i] = static_cast<float>(p.y());
    points.z[i] = static_cast<float>(p.z());
    const double noise = params.sigma_per_square_metre * p.z() * p.z();
    points.inverse_variance[i] =
        static_cast<float>(1 / (params.sigma * params.sigma + noise * noise));
    points.mean_depth += p.z() / static_cast<double>(points.count);
  }
  points.inverse_noise = points.inverse_variance;
  return points;
}

DepthPoints withoutBias(const DepthPoints& points, const DepthBias& bias) {
  DepthPoints result = points;
  result.bias_variance = bias.variance;
  for (size_t i = 0; i < points.count; ++i) {
    const double z = points.z[i];
    const auto factor = static_cast<float>(1 + bias.mean * z);
    for (std::vector<float>* v : {&result.x, &result.y, &result.z}) (*v)[i] *= factor;
    const double variance = 1 / static_cast<double>(points.inverse_noise[i]);
    result.inverse_variance[i] = static_cast<float>(1 / (variance + bias.variance * z * z * z * z));
  }
  return result;
}

}  // namespace edge_mcl
