/// Thin edges of a camera image.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Edges of one image: a thin 8-connected map and the gradient that gives their direction.
struct EdgeImage {
  cv::Mat grey;   ///< CV_8U, as received
  cv::Mat edges;  ///< CV_8U, 255 on an edge; never inside the ignore mask
  /// Gradients are taken of so many steps per grey level: in whole levels
  /// weak noise would be rounded to nothing in most pixels and to an edge in the others.
  static constexpr int kGradientScale = 8;
  /// The strong threshold is never below: about one and a half grey levels across an edge.
  static constexpr double kLeastThreshold = 24 * kGradientScale;
  cv::Mat gradient_x;           ///< CV_16S, Scharr times kGradientScale
  cv::Mat gradient_y;           ///< CV_16S
  cv::Mat ignore;               ///< CV_8U, 255 = ignored, dilated; empty without a mask
  double strong_threshold = 0;  ///< gradient magnitude from which an edge starts

  int width() const { return grey.cols; }
  int height() const { return grey.rows; }
  size_t edgeCount() const;

  /// Unit gradient at a pixel (the edge's normal); zero where the gradient vanishes.
  Eigen::Vector2d normalAt(int x, int y) const;
  /// Position of the gradient's ridge near an edge pixel, to sub-pixel accuracy: parabola through
  /// the magnitudes one pixel to either side along the gradient.
  Eigen::Vector2d subPixel(int x, int y) const { return subPixel(x, y, normalAt(x, y)); }
  /// @param normal normalAt(x, y).
  Eigen::Vector2d subPixel(int x, int y, const Eigen::Vector2d& normal) const;
};

/// Grey image of any 8- or 16-bit, 1-, 3- or 4-channel image. @throws InputError otherwise.
cv::Mat toGrey(const cv::Mat& image, const std::string& origin);

/// Weights of the smoothing for the pixel itself and its neighbours to either side, of kBlurUnit in
/// all. With so few steps sums over rows and columns are exact in single precision, so that the
/// edges do not depend on the machine, nor on the order of additions.
std::vector<int> blurWeights(double sigma);
constexpr int kBlurUnit = 64;

/// Ignored pixels of a mask (non-zero = ignore) after image.mask_dilation: CV_8U, 255 = ignored;
/// empty for an empty mask. @throws InputError when the mask is not of `size` or type CV_8U.
cv::Mat ignoredPixels(const cv::Mat& mask, cv::Size size, const ImageParameters& params,
                      const std::string& origin);

/// Finds edges of a grey CV_8U image. @param ignore ignoredPixels() of its mask.
EdgeImage findEdgesOf(const cv::Mat& grey, const cv::Mat& ignore, const ImageParameters& params);

/// Finds edges. The strong threshold is the gradient exceeded by `edge_share` of the pixels, but
/// at least `noise_factor` times the image's noise; so it follows the exposure.
/// @param mask CV_8U, non-zero = ignore; empty for none.
/// @throws InputError when the mask's size or type differs.
EdgeImage findEdges(const cv::Mat& image, const cv::Mat& mask, const ImageParameters& params,
                    const std::string& origin);

}  // namespace edge_mcl
