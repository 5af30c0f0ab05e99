/// Where what is in the window.
#pragma once

#include <opencv2/core.hpp>

namespace edge_mcl {

/// Without gaps: the space at the left, above legend and strips; at the right the camera image
/// twice, once with edges, once with masks.
struct ViewLayout {
  cv::Rect space, legend, strips, edges, masks;
};

/// The width of `space` is a multiple of four pixels.
/// @param image of the camera, for its proportions; empty: 4 to 3.
ViewLayout layoutOf(const cv::Size& window, const cv::Size& image);

}  // namespace edge_mcl
