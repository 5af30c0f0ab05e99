/// The ray of every pixel, for any camera model.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// Inverse of CameraModel::project, computed once: (X/Z, Y/Z) of every pixel's centre.
class CameraRays {
 public:
  /// @throws InputError when the distortion of more than a tenth of the pixels has no inverse.
  explicit CameraRays(const CameraModel& camera);

  int width() const { return width_; }
  int height() const { return height_; }
  /// NaN where the model shows nothing (outside the monotone part of the distortion).
  const Eigen::Vector2f& at(int x, int y) const { return rays_[index(x, y)]; }
  /// How the ray changes per pixel to the right and per pixel down.
  struct Slope {
    Eigen::Vector2f by_x, by_y;
  };
  Slope slopeAt(int x, int y) const;

 private:
  size_t index(int x, int y) const { return static_cast<size_t>(y) * width_ + x; }
  int width_, height_;
  std::vector<Eigen::Vector2f> rays_;
};

/// (X/Z, Y/Z) of a pixel, by Newton's method. @return false where it has none.
bool unproject(const CameraModel& camera, const Eigen::Vector2d& pixel, Eigen::Vector2d* ray);

}  // namespace edge_mcl
