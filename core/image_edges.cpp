#include "edge_mcl/core/image_edges.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "edge_mcl/core/error.h"

namespace edge_mcl {

size_t EdgeImage::edgeCount() const { return static_cast<size_t>(cv::countNonZero(edges)); }

Eigen::Vector2d EdgeImage::normalAt(int x, int y) const {
  const Eigen::Vector2d g(gradient_x.at<int16_t>(y, x), gradient_y.at<int16_t>(y, x));
  const double norm = g.norm();
  return norm > 0 ? Eigen::Vector2d(g / norm) : Eigen::Vector2d::Zero();
}

namespace {

/// Bilinear gradient magnitude, zero outside.
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

/// Threshold from a regular sub-sample of the magnitudes outside the mask.
double strongThreshold(const EdgeImage& image, const ImageParameters& params) {
  std::vector<float> magnitudes;
  magnitudes.reserve(image.grey.total() / 9 + 1);
  for (int y = 1; y < image.height(); y += 3)
    for (int x = 1; x < image.width(); x += 3) {
      if (!image.ignore.empty() && image.ignore.at<uint8_t>(y, x)) continue;
      const auto gx = static_cast<float>(image.gradient_x.at<int16_t>(y, x));
      const auto gy = static_cast<float>(image.gradient_y.at<int16_t>(y, x));
      magnitudes.push_back(std::sqrt(gx * gx + gy * gy));
    }
  // About one and a half grey levels across an edge.
  constexpr double kLeast = 24 * EdgeImage::kGradientScale;
  if (magnitudes.empty()) return kLeast;
  auto sorted_below = magnitudes.begin();  // nothing from here on is smaller than what is before
  const auto quantile = [&](double q) {    // to be called with growing q
    const auto nth =
        magnitudes.begin() + static_cast<long>(q * static_cast<double>(magnitudes.size() - 1));
    std::nth_element(sorted_below, nth, magnitudes.end());
    sorted_below = nth;
    return static_cast<double>(*nth);
  };
  // The magnitude of Gaussian noise is Rayleigh distributed: median = 1.177 sigma. The lower
  // quartile (0.759 sigma) stays noise even when texture fills half of the image.
  const bool edges_are_few = params.edge_share <= 0.75;
  const double first = quantile(edges_are_few ? 0.25 : 1 - params.edge_share);
  const double second = quantile(edges_are_few ? 1 - params.edge_share : 0.25);
  const double noise = (edges_are_few ? first : second) / 0.759;
  return std::max({kLeast, edges_are_few ? second : first, params.noise_factor * noise});
}

/// Keeps edges that lie on a straight segment of their own direction.
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
  cv::Mat eight = image;
  if (image.depth() == CV_16U) image.convertTo(eight, CV_8U, 1.0 / 256);
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

EdgeImage findEdges(const cv::Mat& image, const cv::Mat& mask, const ImageParameters& params,
                    const std::string& origin) {
  EdgeImage result;
  result.grey = toGrey(image, origin);
  if (!mask.empty()) {
    if (mask.size() != result.grey.size())
      throw InputError(origin + ": the mask has " + std::to_string(mask.cols) + "x" +
                       std::to_string(mask.rows) + " pixels, the image " +
                       std::to_string(result.width()) + "x" + std::to_string(result.height()));
    if (mask.type() != CV_8U) throw InputError(origin + ": the mask must be 8-bit grey");
    cv::compare(mask, 0, result.ignore, cv::CMP_NE);
    if (params.mask_dilation > 0) {
      const int size = 2 * params.mask_dilation + 1;
      cv::dilate(result.ignore, result.ignore,
                 cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(size, size)));
    }
  }
  cv::Mat smooth;  // Scharr's weights add up to 16: 16 * 255 * 8 just fits into 16 bits
  result.grey.convertTo(smooth, CV_16S, EdgeImage::kGradientScale);
  if (params.blur_sigma > 0)
    cv::GaussianBlur(smooth, smooth, cv::Size(), params.blur_sigma, params.blur_sigma,
                     cv::BORDER_REPLICATE);
  cv::Scharr(smooth, result.gradient_x, CV_16S, 1, 0, 1, 0, cv::BORDER_REPLICATE);
  cv::Scharr(smooth, result.gradient_y, CV_16S, 0, 1, 1, 0, cv::BORDER_REPLICATE);
  result.strong_threshold = strongThreshold(result, params);
  cv::Canny(result.gradient_x, result.gradient_y, result.edges,
            params.hysteresis * result.strong_threshold, result.strong_threshold, true);
  if (params.straight_segments) keepStraightSegments(&result, params.min_segment_length);
  if (!result.ignore.empty()) result.edges.setTo(0, result.ignore);
  return result;
}

}  // namespace edge_mcl
