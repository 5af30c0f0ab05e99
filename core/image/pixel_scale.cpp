#include "edge_mcl/core/image/pixel_scale.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

double pixelScale(const ImageParameters& image, cv::Size size) {
  constexpr double kLeast = 0.5, kMost = 4;
  if (!(image.reference_width > 0) || size.area() <= 0) return 1;
  const double width = image.reference_width, reference = 0.75 * width * width;
  return std::clamp(std::sqrt(static_cast<double>(size.area()) / reference), kLeast, kMost);
}

namespace {

/// A length in whole pixels, limited to the range of its parameter.
int rounded(double scale, int length, int least, int most) {
  return std::clamp(static_cast<int>(std::lround(scale * length)), least, most);
}

}  // namespace

ImageParameters scaledBy(double scale, ImageParameters image) {
  // Twice the default at half the width, and some room for more.
  constexpr double kLargestShare = 0.3;
  image.blur_sigma = std::min(scale * image.blur_sigma, 19.0);
  image.edge_share = std::min(image.edge_share / scale, std::max(image.edge_share, kLargestShare));
  image.min_segment_length *= scale;
  image.mask_dilation = rounded(scale, image.mask_dilation, 0, 100);
  image.search_length = rounded(scale, image.search_length, 2, 200);
  image.contrast_window = rounded(scale, image.contrast_window, 0, 2000);
  image.clutter_window = rounded(scale, image.clutter_window, 16, 2000);
  return image;
}

LikelihoodParameters scaledBy(double scale, LikelihoodParameters likelihood) {
  likelihood.sigma *= scale;
  likelihood.correlation_length *= scale;
  likelihood.border_fade *= scale;
  return likelihood;
}

}  // namespace edge_mcl
