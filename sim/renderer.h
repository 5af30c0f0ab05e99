/// Colour, depth and object images of a scene by ray casting.
///
/// Rays instead of a rasteriser: every camera model's distortion is exact, depth and object numbers
/// are those of the very ray through the pixel's centre, and no display or GPU is needed.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/camera/camera_rays.h"
#include "edge_mcl/sim/scene.h"

namespace edge_mcl {

/// Where the light comes from.
struct Lighting {
  double ambient = 0.45;  ///< share that comes from everywhere
  /// Lamps, map frame, metres; empty: one under the middle of the ceiling.
  std::vector<Eigen::Vector3f> lamps;
  bool shadows = false;
};

struct RenderedImage {
  cv::Mat color;   ///< CV_8UC3, blue green red
  cv::Mat depth;   ///< CV_32F, metres along the optical axis; 0: nothing there
  cv::Mat object;  ///< CV_16U, 0: building, k: object k - 1, 65535: nothing there
};

class Renderer {
 public:
  Renderer(const Scene& scene, const CameraModel& camera, Lighting lighting);

  /// The scene as it was last committed. Pixels on the outline of a face are the mean of sixteen
  /// rays, others one ray.
  RenderedImage render(const Pose& T_map_camera) const;

 private:
  Eigen::Vector3f shade(const Eigen::Vector3f& eye, const Eigen::Vector3f& direction,
                        const SceneHit& hit) const;
  const Scene& scene_;
  CameraRays rays_;
  Lighting lighting_;
  float lamp_strength_;
};

}  // namespace edge_mcl
