/// Straight segments of an image, lifted to the map by its depth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_rays.h"

namespace edge_mcl {

/// An image with its depth and its pose.
struct MappingImage {
  cv::Mat grey;   ///< CV_8U
  cv::Mat depth;  ///< CV_32F of the same size, metres along the optical axis; 0: no return
  Pose T_map_camera = Pose::Identity();
  uint32_t number = 0;
};

/// A straight segment that one image has seen.
struct DepthSegment {
  uint32_t image = 0;
  Pose T_map_camera = Pose::Identity();
  Eigen::Vector3d start, end;          ///< map, metres
  Eigen::Vector3d ray_start, ray_end;  ///< (X/Z, Y/Z, 1) of the ends in the image, camera axes

  double length() const { return (end - start).norm(); }
};

struct SegmentOptions {
  double min_pixels = 30;  ///< shorter segments have no certain direction
  double max_depth = 4;    ///< m; the noise of structured light exceeds 2 cm beyond
  /// Largest residual of the inverse depth along a segment, 1/m: 8 mm at 1 m and 7 cm at 3 m.
  double inverse_depth_tolerance = 0.008;
  double min_inliers = 0.6;  ///< share of the points of a segment that lie on a straight line
  double min_length = 0.08;  ///< m, in the map
  /// The depth beside a segment is extrapolated to it where this changes it by at least this share,
  /// as on a floor that is seen at a small angle. Elsewhere the extrapolation adds noise only.
  double min_extrapolation = 0.08;
  /// Whether both sides of a segment need depth. A rendered scan has depth wherever it has surface,
  /// so a segment beside a hole is the border of the scan.
  bool needs_both_sides = false;
};

/// Finds the straight segments of an image and their places in the map. At a step of the depth the
/// nearer side owns the segment. Segments without enough depth, or whose depth is not that of a
/// straight line, are left out.
/// @param rays of the camera; image and depth have its size.
std::vector<DepthSegment> findDepthSegments(const MappingImage& image, const CameraRays& rays,
                                            const SegmentOptions& options);

}  // namespace edge_mcl
