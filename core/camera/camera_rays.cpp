#include "edge_mcl/core/camera/camera_rays.h"

#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

bool unproject(const CameraModel& camera, const Eigen::Vector2d& pixel, Eigen::Vector2d* ray) {
  constexpr double kClose = 1e-7;  // pixels
  const Eigen::Vector2d plain((pixel.x() - camera.cx) / camera.fx,
                              (pixel.y() - camera.cy) / camera.fy);
  // In a fisheye image the distance from the centre tells the angle. The radius to start from is
  // the tangent of the angle.
  const double angle = std::min(plain.norm(), 1.5);
  Eigen::Vector2d at = plain;
  if (camera.distortion == DistortionModel::kEquidistant && angle > 1e-9)
    at = plain / plain.norm() * std::tan(angle);
  double last = std::numeric_limits<double>::infinity();
  double damping = 1;
  Eigen::Vector2d step = Eigen::Vector2d::Zero();
  for (int i = 0; i < 60; ++i) {
    Eigen::Vector2d projected;
    Eigen::Matrix<double, 2, 3> jacobian;
    const bool inside = camera.project({at.x(), at.y(), 1}, &projected, &jacobian);
    const double error = inside ? (projected - pixel).norm() : last + 1;
    if (error < kClose) {
      *ray = at;
      return true;
    }
    if (error >= last) {  // halve the last step
      damping *= 0.5;
      at -= damping * step;
      if (damping < 1e-4) return false;
      continue;
    }
    last = error;
    damping = 1;
    step = jacobian.leftCols<2>().inverse() * (pixel - projected);
    if (!step.allFinite()) return false;
    at += step;
  }
  return false;
}

CameraRays::CameraRays(const CameraModel& camera)
    : width_(camera.width), height_(camera.height), rays_(static_cast<size_t>(width_) * height_) {
  std::vector<size_t> without(height_, 0);
  tbb::parallel_for(0, height_, [&](int y) {
    for (int x = 0; x < width_; ++x) {
      Eigen::Vector2d ray;
      if (unproject(camera, {x, y}, &ray)) {
        rays_[index(x, y)] = ray.cast<float>();
      } else {
        rays_[index(x, y)].setConstant(std::numeric_limits<float>::quiet_NaN());
        ++without[y];
      }
    }
  });
  size_t total = 0;
  for (const size_t n : without) total += n;
  if (total > rays_.size() / 10)
    throw InputError("camera: the distortion has no inverse for " + std::to_string(total) + " of " +
                     std::to_string(rays_.size()) + " pixels");
}

CameraRays::Slope CameraRays::slopeAt(int x, int y) const {
  const auto between = [&](int x0, int y0, int x1, int y1, int pixels) -> Eigen::Vector2f {
    return (at(x1, y1) - at(x0, y0)) / static_cast<float>(pixels);
  };
  const int left = std::max(x - 1, 0), right = std::min(x + 1, width_ - 1);
  const int top = std::max(y - 1, 0), bottom = std::min(y + 1, height_ - 1);
  return {between(left, y, right, y, right - left), between(x, top, x, bottom, bottom - top)};
}

}  // namespace edge_mcl
