/// The rays of all pixels, for any camera model.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// Table of the rays (X/Z, Y/Z) through the centres of all pixels. It is the inverse of
/// CameraModel::project(), computed once.
class CameraRays {
 public:
  /// Computes all rays.
  /// @throws InputError when the distortion of more than a tenth of the pixels has no inverse.
  explicit CameraRays(const CameraModel& camera);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Ray of a pixel. It is NaN where the pixel has no ray (outside the monotone part of the
  /// distortion).
  const Eigen::Vector2f& at(int x, int y) const { return rays_[index(x, y)]; }
  /// Change of the ray per pixel to the right (by_x) and per pixel down (by_y).
  struct Slope {
    Eigen::Vector2f by_x, by_y;
  };
  Slope slopeAt(int x, int y) const;

 private:
  size_t index(int x, int y) const { return static_cast<size_t>(y) * width_ + x; }
  int width_, height_;
  std::vector<Eigen::Vector2f> rays_;
};

/// Computes (X/Z, Y/Z) of a pixel, by Newton's method. @return false where the pixel has no ray.
bool unproject(const CameraModel& camera, const Eigen::Vector2d& pixel, Eigen::Vector2d* ray);

}  // namespace edge_mcl
