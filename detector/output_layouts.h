/// Decodes the raw output of detection networks into boxes.
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
  cv::Mat mask;  ///< CV_32F, 0 to 1, to be stretched over the box; empty: the whole box
};

/// Returns every box whose best class has a score of at least `threshold`. Overlapping boxes are
/// not merged. @throws InputError when the shape of an output does not fit the layout and the
/// number of classes (the text names both), or when a box has a class without a name.
std::vector<NetworkBox> decodeBoxes(const DetectorModel& model, const std::vector<cv::Mat>& outputs,
                                    float threshold);

}  // namespace edge_mcl
