/// Pictures of what was found, as in the paper's figure 5.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/detector/detections.h"

namespace edge_mcl {

/// The image with every object tinted in its class's colour, outlined, and named with its number
/// (where it is tracked) and score; an object that the network did not see in this very image has
/// a broken outline.
cv::Mat drawDetections(const cv::Mat& image, const Detections& detections,
                       const std::vector<std::string>& classes);

/// Blue green red; colours that most colour-blind readers can tell apart.
cv::Scalar colorOfClass(int class_id);

}  // namespace edge_mcl
