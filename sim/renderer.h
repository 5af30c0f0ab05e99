/// Renders colour, depth and object images of a scene by ray casting.
///
/// Reasons for rays instead of a rasteriser: the distortion of every camera model is exact, depth
/// and object number belong to the ray through the centre of the pixel, and neither a display nor a
/// GPU is needed.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/camera/camera_rays.h"
#include "edge_mcl/sim/scene.h"

namespace edge_mcl {

/// Where the light comes from.
struct Lighting {
  double ambient = 0.45;  ///< share of the light that comes from all directions
  /// Positions of lamps, map frame, metres; empty: one lamp under the middle of the ceiling.
  std::vector<Eigen::Vector3f> lamps;
  bool shadows = false;
};

/// Images of one camera pose, all of the camera's size.
struct RenderedImage {
  cv::Mat color;   ///< CV_8UC3, blue green red
  cv::Mat depth;   ///< CV_32F, metres along the optical axis; 0: the ray meets nothing
  cv::Mat object;  ///< CV_16U, 0: building, k: object k - 1, 65535: the ray meets nothing
};

/// Renders a scene for one camera.
class Renderer {
 public:
  /// @param scene must outlive this object.
  Renderer(const Scene& scene, const CameraModel& camera, Lighting lighting);

  /// Renders the scene in the state of its last commit(). The colour of a pixel on the outline of a
  /// face is the mean of 16 rays, the colour of any other pixel comes from one ray.
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
