/// Straight segments of an image as arcs of great circles, and the orientations of a camera that
/// make them parallel to the axes of a building.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

/// A straight segment of an image. Directions are unit vectors in the optical frame.
struct ImageLine {
  Eigen::Vector3d start, end;
  Eigen::Vector3d normal;  ///< of the plane through the camera and the segment
  double length = 0;       ///< rad
};

/// Finds the straight segments of an image (R. Grompone von Gioi et al., "LSD: a Line Segment
/// Detector", Image Processing On Line 2012, in OpenCV's implementation). Segments that are mostly
/// under the mask are left out, and so are segments that are shorter than about 1.5 degrees.
std::vector<ImageLine> findImageLines(const EdgeImage& image, const CameraModel& camera);

/// A direction that is known in the optical frame.
struct KnownUp {
  Eigen::Vector3d up_camera = -Eigen::Vector3d::UnitY();
  double sigma = 0.35;  ///< standard deviation per axis, rad
};

/// An orientation of the camera, up to quarter turns about the vertical.
struct AxesRotation {
  Eigen::Matrix3d R_building_camera = Eigen::Matrix3d::Identity();
  double support = 0;  ///< length of the segments parallel to an axis, rad
};

/// Finds orientations for which many segments are parallel to the axes of a building. Every
/// hypothesis comes from two directions: "up" or the intersection of two segments, and a segment.
/// Then it is fitted to all segments that agree.
/// @return best first, at most `most`, none within 3 degrees of another. Empty when the image has
///   too few segments.
std::vector<AxesRotation> rotationsOfAxes(const std::vector<ImageLine>& lines, const KnownUp& up,
                                          size_t most);

}  // namespace edge_mcl
