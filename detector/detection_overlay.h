/// Draws detected objects into the image, as in the paper's figure 5.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/detector/detections.h"

namespace edge_mcl {

/// Draws every object with a tint and an outline in the colour of its class, and with class name,
/// number (if it is tracked) and score. The outline is broken when the network did not see the
/// object in this image. @param image CV_8UC3 or CV_8U. @param classes names by class number.
/// @return CV_8UC3.
cv::Mat drawDetections(const cv::Mat& image, const Detections& detections,
                       const std::vector<std::string>& classes);

/// Returns the colour of a class: blue, green, red. Most colour-blind readers can tell the colours
/// apart.
cv::Scalar colorOfClass(int class_id);

}  // namespace edge_mcl
