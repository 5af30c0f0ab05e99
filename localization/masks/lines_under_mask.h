/// Finds the model lines under a mask, and how much of them the image shows nevertheless.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/image/edge_pixels.h"

namespace edge_mcl {

/// The visible part of one model line under one connected part of a mask. Lengths in pixels.
struct LineUnderMask {
  /// Projection of the piece around one sample.
  struct Piece {
    Eigen::Vector2d from, to;  ///< pixels
  };
  uint32_t line = 0;  ///< index into EdgeModel::lines
  double length = 0;  ///< of all pieces
  double shown = 0;   ///< length of the pieces with an image edge near them
  std::vector<Piece> pieces;
};

/// Largest distance and angle between a model edge and its image edge.
struct EdgeReach {
  double pixels = 4;           ///< largest distance along the normal
  double tolerance_cos = 0.9;  ///< cosine of the largest angle between their directions
};

/// Finds the visible model lines under a mask at a camera pose.
/// @param mask CV_8U, of the camera's size, non-zero = ignored. @param edges of the whole image,
/// found without the mask. @param visible set from about the position of the camera.
/// @param sample_step distance between the samples of the set, metres.
/// @return one entry per line and connected part of the mask, in this order.
std::vector<LineUnderMask> linesUnderMask(const cv::Mat& mask, const EdgePixels& edges,
                                          const VisibleSet& visible, const CameraModel& camera,
                                          const Pose& T_map_camera, double sample_step,
                                          const EdgeReach& reach);

/// Clears the mask in a band along the line. @param band width to either side, pixels.
void clearAlong(const LineUnderMask& line, double band, cv::Mat* mask);

}  // namespace edge_mcl
