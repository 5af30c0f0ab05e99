/// Divides the viewer's window into its parts.
#pragma once

#include <opencv2/core.hpp>

namespace edge_mcl {

/// Rectangles of the parts, pixels, without gaps. Left: the 3D scene (`space`), below it the
/// legend. Right: the camera image with edges, below it with masks. The strips lie below the
/// legend.
struct ViewLayout {
  cv::Rect space, legend, strips, edges, masks;
};

/// Computes the layout. The width of `space` is a multiple of four pixels.
/// @param window its size, pixels. @param image size of the camera image, for its proportions;
/// empty: 4 to 3.
ViewLayout layoutOf(const cv::Size& window, const cv::Size& image);

}  // namespace edge_mcl
