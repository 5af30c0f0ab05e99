/// Boxes from the raw output of detection networks.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/detector/detector_model.h"

namespace edge_mcl {

/// A box in pixels of the network's input.
struct NetworkBox {
  int class_id = 0;
  float score = 0;
  cv::Rect2f box;
  cv::Mat mask;  ///< CV_32F, 0 to 1, stretched over the box; empty: all of it
};

/// Every box whose best class scores at least `threshold`; overlapping ones are not merged.
/// @throws InputError when an output's shape is not what the layout and the number of classes ask
/// for; it names both. Likewise for a box of a class that has no name.
std::vector<NetworkBox> decodeBoxes(const DetectorModel& model, const std::vector<cv::Mat>& outputs,
                                    float threshold);

}  // namespace edge_mcl
