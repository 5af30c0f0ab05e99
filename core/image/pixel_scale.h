/// Lengths in pixels for images of any size.
///
/// Parameters in pixels hold for images as large as 640 x 480 (`image.reference_width`). In an
/// image of half that width the same edge is half as many pixels wide, lies half as many pixels
/// beside its model line, and edges are a share of all pixels twice as large.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/core/base/measurement_parameters.h"

namespace edge_mcl {

/// Factor on every length in pixels: the root of the number of pixels over that of a 4:3 image of
/// the reference width. It is limited to 1/2 to 4. In smaller images half a pixel of noise decides.
double pixelScale(const ImageParameters& image, cv::Size size);

/// The parameters with all lengths in pixels times `scale`, and `edge_share` over `scale`.
ImageParameters scaledBy(double scale, ImageParameters image);
/// The parameters with all lengths in pixels times `scale`.
LikelihoodParameters scaledBy(double scale, LikelihoodParameters likelihood);

}  // namespace edge_mcl
