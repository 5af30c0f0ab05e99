/// A camera in the furnished rooms, and its picture.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/base/se3.h"
#include "support/scenes.h"

namespace edge_mcl::test {

/// Pose of the camera, T_map_camera.
inline Pose roomView() { return lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15}); }

inline CameraModel roomCamera() { return pinhole(320, 240, 220); }

/// Picture of roomCamera() at roomView(), without distortion. It is rendered once.
inline cv::Mat roomPicture() {
  static const cv::Mat picture = render(furnishedRooms(), roomCamera(), roomView(), 1);
  return picture;
}

/// Random poses around roomView(). @param metres, radians standard deviation per axis
inline std::vector<Pose> posesAroundView(size_t n, double metres, double radians, uint64_t seed) {
  RandomSource random(seed);
  std::vector<Pose> poses;
  poses.reserve(n);
  Twist scale;
  scale << metres, metres, metres, radians, radians, radians;
  for (size_t i = 0; i < n; ++i)
    poses.push_back(roomView() * expSe3(scale.cwiseProduct(random.normalTwist())));
  return poses;
}

}  // namespace edge_mcl::test
