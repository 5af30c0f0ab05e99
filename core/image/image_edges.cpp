#include "edge_mcl/core/image/image_edges.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/edge_thresholds.h"
#include "edge_mcl/core/image/edge_tracing.h"
#include "edge_mcl/core/image/eight_bits.h"

namespace edge_mcl {

size_t EdgeImage::edgeCount() const { return static_cast<size_t>(cv::countNonZero(edges)); }

Eigen::Vector2d EdgeImage::normalAt(int x, int y) const {
  const Eigen::Vector2d g(gradient_x.at<int16_t>(y, x), gradient_y.at<int16_t>(y, x));
  const double norm = g.norm();
  return norm > 0 ? Eigen::Vector2d(g / norm) : Eigen::Vector2d::Zero();
}

namespace {

/// Gradient magnitude by bilinear interpolation; zero outside the image.
double magnitudeAt(const EdgeImage& image, double x, double y) {
  if (x < 0 || y < 0) return 0;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  if (x0 + 1 >= image.width() || y0 + 1 >= image.height()) return 0;
  const auto row = [&](int py) {
    const int16_t *gx = image.gradient_x.ptr<int16_t>(py) + x0,
                  *gy = image.gradient_y.ptr<int16_t>(py) + x0;
    const auto at = [&](int i) {
      const auto a = static_cast<float>(gx[i]), b = static_cast<float>(gy[i]);
      return static_cast<double>(std::sqrt(a * a + b * b));
    };
    const double fx = x - x0;
    return (1 - fx) * at(0) + fx * at(1);
  };
  const double fy = y - y0;
  return (1 - fy) * row(y0) + fy * row(y0 + 1);
}

/// Removes edges that are not on a straight segment of at least `min_length` pixels.
void keepStraightSegments(EdgeImage* image, double min_length) {
  std::vector<cv::Vec4f> segments;
  cv::createLineSegmentDetector(cv::LSD_REFINE_NONE)->detect(image->grey, segments);
  cv::Mat near_segment = cv::Mat::zeros(image->edges.size(), CV_8U);
  for (const cv::Vec4f& s : segments)
    if (std::hypot(s[2] - s[0], s[3] - s[1]) >= min_length)
      cv::line(near_segment, cv::Point(cvRound(s[0]), cvRound(s[1])),
               cv::Point(cvRound(s[2]), cvRound(s[3])), cv::Scalar(255), 3);
  image->edges &= near_segment;
}

}  // namespace

Eigen::Vector2d EdgeImage::subPixel(int x, int y, const Eigen::Vector2d& n) const {
  const double before = magnitudeAt(*this, x - n.x(), y - n.y());
  const double here = magnitudeAt(*this, x, y);
  const double after = magnitudeAt(*this, x + n.x(), y + n.y());
  const double curvature = before - 2 * here + after;
  double offset = 0;
  if (curvature < 0) offset = std::clamp(0.5 * (before - after) / curvature, -0.7, 0.7);
  return Eigen::Vector2d(x, y) + offset * n;
}

cv::Mat toGrey(const cv::Mat& image, const std::string& origin) {
  if (image.empty()) throw InputError(origin + ": the image is empty");
  const cv::Mat eight = toEightBits(image);
  if (eight.depth() != CV_8U) throw InputError(origin + ": only 8- and 16-bit images can be used");
  if (eight.channels() == 1) return eight.isContinuous() ? eight : eight.clone();
  cv::Mat grey;
  if (eight.channels() == 3)
    cv::cvtColor(eight, grey, cv::COLOR_BGR2GRAY);
  else if (eight.channels() == 4)
    cv::cvtColor(eight, grey, cv::COLOR_BGRA2GRAY);
  else
    throw InputError(origin + ": an image with " + std::to_string(eight.channels()) +
                     " channels cannot be used");
  return grey;
}

std::vector<int> blurWeights(double sigma) {
  if (!(sigma > 0)) return {kBlurUnit};
  const int radius = std::max(1, static_cast<int>(std::ceil(4 * sigma)));
  // Sum of the weights from this neighbour on, not normalised.
  std::vector<double> beyond(radius + 2, 0);
  for (int i = radius; i >= 0; --i)
    beyond[i] = beyond[i + 1] + std::exp(-0.5 * i * i / sigma / sigma);
  const double total = beyond[0] + beyond[1];
  // Sums of weights are rounded and not the weights, so the rounded weights add up to kBlurUnit.
  const auto rounded = [&](int i) {
    return static_cast<int>(std::lround(kBlurUnit * beyond[i] / total));
  };
  std::vector<int> weights = {kBlurUnit - 2 * rounded(1)};
  for (int i = 1; i <= radius && rounded(i) > 0; ++i)
    weights.push_back(rounded(i) - rounded(i + 1));
  return weights;
}

cv::Mat ignoredPixels(const cv::Mat& mask, cv::Size size, const ImageParameters& params,
                      const std::string& origin) {
  cv::Mat ignored;
  if (mask.empty()) return ignored;
  if (mask.size() != size)
    throw InputError(origin + ": the mask has " + std::to_string(mask.cols) + "x" +
                     std::to_string(mask.rows) + " pixels, the image has " +
                     std::to_string(size.width) + "x" + std::to_string(size.height));
  if (mask.type() != CV_8U) throw InputError(origin + ": the mask must be 8-bit grey");
  cv::compare(mask, 0, ignored, cv::CMP_NE);
  if (params.mask_dilation > 0) {
    const int across = 2 * params.mask_dilation + 1;
    cv::dilate(ignored, ignored,
               cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(across, across)));
  }
  return ignored;
}

namespace {

/// Gaussian smoothing with blurWeights(). Every sum is a whole number of units below 2^24.
void smooth(double sigma, cv::Mat* image) {
  const std::vector<int> weights = blurWeights(sigma);
  const int radius = static_cast<int>(weights.size()) - 1;
  if (radius == 0) return;
  cv::Mat kernel(2 * radius + 1, 1, CV_32F);
  for (int i = -radius; i <= radius; ++i)
    kernel.at<float>(radius + i) = static_cast<float>(weights[std::abs(i)]) / kBlurUnit;
  static_assert(kBlurUnit * kBlurUnit * 255 * EdgeImage::kGradientScale < 1 << 24);
  cv::sepFilter2D(*image, *image, CV_16S, kernel, kernel, cv::Point(-1, -1), 0,
                  cv::BORDER_REPLICATE);
}

}  // namespace

EdgeImage findEdges(const cv::Mat& image, const cv::Mat& mask, const ImageParameters& params,
                    const std::string& origin) {
  const cv::Mat grey = toGrey(image, origin);
  return findEdgesOf(grey, ignoredPixels(mask, grey.size(), params, origin), params);
}

EdgeImage findEdgesOf(const cv::Mat& grey, const cv::Mat& ignore, const ImageParameters& params) {
  EdgeImage result;
  result.grey = grey;
  result.ignore = ignore;
  cv::Mat smoothed;  // 16 bits: Scharr's weights add up to 16, and 16 * 255 * 8 just fits
  result.grey.convertTo(smoothed, CV_16S, EdgeImage::kGradientScale);
  smooth(params.blur_sigma, &smoothed);
  cv::Scharr(smoothed, result.gradient_x, CV_16S, 1, 0, 1, 0, cv::BORDER_REPLICATE);
  cv::Scharr(smoothed, result.gradient_y, CV_16S, 0, 1, 1, 0, cv::BORDER_REPLICATE);
  const EdgeThresholds thresholds(result.gradient_x, result.gradient_y, ignore, params,
                                  EdgeImage::kLeastThreshold);
  result.strong_threshold = thresholds.strong();
  result.edges = traceEdges(result.gradient_x, result.gradient_y, thresholds);
  if (params.straight_segments) keepStraightSegments(&result, params.min_segment_length);
  if (!result.ignore.empty()) result.edges.setTo(0, result.ignore);
  return result;
}

}  // namespace edge_mcl
