/// Detection of thin edges in a camera image.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Edges of one image: a thin 8-connected map, and the gradient that gives their direction.
struct EdgeImage {
  cv::Mat grey;   ///< CV_8U, as received
  cv::Mat edges;  ///< CV_8U, 255 on an edge; never inside the ignore mask
  /// Steps per grey level in the image whose gradients are taken. With whole grey levels, weak
  /// noise would be rounded to nothing in most pixels and to an edge in the others.
  static constexpr int kGradientScale = 8;
  /// Lower limit of the strong threshold: about one and a half grey levels across an edge.
  static constexpr double kLeastThreshold = 24 * kGradientScale;
  cv::Mat gradient_x;  ///< CV_16S, Scharr derivative times kGradientScale
  cv::Mat gradient_y;  ///< CV_16S
  cv::Mat ignore;      ///< CV_8U, 255 = ignored, after dilation; empty without a mask
  /// Gradient magnitude at which an edge starts where the image has its full contrast.
  double strong_threshold = 0;

  int width() const { return grey.cols; }
  int height() const { return grey.rows; }
  size_t edgeCount() const;

  /// Unit gradient at a pixel, which is the normal of the edge. Zero where the gradient vanishes.
  Eigen::Vector2d normalAt(int x, int y) const;
  /// Sub-pixel position of the gradient's ridge near an edge pixel. It is the top of a parabola
  /// through the gradient magnitudes at the pixel and one pixel to either side along the gradient.
  Eigen::Vector2d subPixel(int x, int y) const { return subPixel(x, y, normalAt(x, y)); }
  /// Sub-pixel position for a known normal. @param normal normalAt(x, y).
  Eigen::Vector2d subPixel(int x, int y, const Eigen::Vector2d& normal) const;
};

/// Grey image (CV_8U) of an 8- or 16-bit image with 1, 3 or 4 channels. It may share the memory of
/// `image`.
/// @param origin named in errors.
/// @throws InputError for other images and for an empty one.
cv::Mat toGrey(const cv::Mat& image, const std::string& origin);

/// Weights of the smoothing: of the pixel itself, then of its neighbours at distance 1, 2, ... to
/// either side. They add up to kBlurUnit. With so few steps, sums over rows and columns are exact
/// in single precision. So the edges depend neither on the machine nor on the order of additions.
/// @param sigma pixels.
std::vector<int> blurWeights(double sigma);
constexpr int kBlurUnit = 64;

/// Ignored pixels of a mask after `image.mask_dilation`: CV_8U, 255 = ignored; empty for an empty
/// mask.
/// @param mask CV_8U, non-zero = ignore.
/// @throws InputError when the mask does not have this size or is not CV_8U.
cv::Mat ignoredPixels(const cv::Mat& mask, cv::Size size, const ImageParameters& params,
                      const std::string& origin);

/// Finds the edges of a grey CV_8U image. @param ignore from ignoredPixels().
EdgeImage findEdgesOf(const cv::Mat& grey, const cv::Mat& ignore, const ImageParameters& params);

/// Finds the edges of an image. The strong threshold is the gradient magnitude that a share
/// `edge_share` of the pixels exceeds. So it follows the exposure. It is at least `noise_factor`
/// times the noise of the image. Dull parts of the image have a lower one, see EdgeThresholds.
/// @param mask CV_8U, non-zero = ignore; empty: no mask.
/// @throws InputError when the size or type of image or mask is wrong.
EdgeImage findEdges(const cv::Mat& image, const cv::Mat& mask, const ImageParameters& params,
                    const std::string& origin);

}  // namespace edge_mcl
