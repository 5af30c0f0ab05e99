#include "edge_mcl/viewer/drawing/view_layout.h"

#include <algorithm>

namespace edge_mcl {

ViewLayout layoutOf(const cv::Size& window, const cv::Size& image) {
  const double proportion =
      image.empty() ? 4.0 / 3 : static_cast<double>(image.width) / image.height;
  const int upper = window.height / 2;
  // The right part is as wide as two images above each other, but at most half of the window.
  int right = std::clamp(cvRound(upper * proportion), window.width / 4, window.width / 2);
  // OpenGL pads the rows of a picture to four bytes, and MRPT's buffer has no room for padding.
  const int left = (window.width - right) / 4 * 4;
  right = window.width - left;
  constexpr int kLegend = 24;
  const int strips = window.height / 4;
  ViewLayout layout;
  layout.space = {0, 0, left, window.height - strips - kLegend};
  layout.legend = {0, layout.space.height, left, kLegend};
  layout.strips = {0, window.height - strips, left, strips};
  layout.edges = {left, 0, right, upper};
  layout.masks = {left, upper, right, window.height - upper};
  return layout;
}

}  // namespace edge_mcl
