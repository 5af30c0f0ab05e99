/// Thin edges from gradients and thresholds.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/core/image/edge_thresholds.h"

namespace edge_mcl {

/// Edges as cv::Canny finds them (L2 norm), but with the thresholds of every tile: pixels on a
/// ridge of the gradient above the weak threshold that are connected to one above the strong
/// threshold.
/// @param gradient_x, gradient_y CV_16S, of one size. @return CV_8U, 255 on an edge
cv::Mat traceEdges(const cv::Mat& gradient_x, const cv::Mat& gradient_y,
                   const EdgeThresholds& thresholds);

}  // namespace edge_mcl
