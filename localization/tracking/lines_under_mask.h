/// What of the model a mask hides, and how much of that the image shows all the same.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/image/edge_pixels.h"

namespace edge_mcl {

/// One line of the model under one connected part of a mask. Lengths in pixels.
struct LineUnderMask {
  struct Piece {
    Eigen::Vector2d from, to;
  };
  uint32_t line = 0;  ///< of EdgeModel::lines
  double length = 0;
  double shown = 0;  ///< of it, with an edge of the image near it
  std::vector<Piece> pieces;
};

/// How near an image edge must be.
struct EdgeReach {
  double pixels = 4;           ///< along the normal
  double tolerance_cos = 0.9;  ///< and of about its direction: cosine of the largest angle
};

/// @param mask CV_8U, of the camera's size, non-zero = ignored. @param edges of the whole image,
/// found without the mask. @param visible from about the camera's position. @param sample_step
/// metres between samples of the set.
/// @return by line, then part of the mask.
std::vector<LineUnderMask> linesUnderMask(const cv::Mat& mask, const EdgePixels& edges,
                                          const VisibleSet& visible, const CameraModel& camera,
                                          const Pose& T_map_camera, double sample_step,
                                          const EdgeReach& reach);

/// Takes a band along the line out of the mask. @param band pixels, to either side.
void clearAlong(const LineUnderMask& line, double band, cv::Mat* mask);

}  // namespace edge_mcl
