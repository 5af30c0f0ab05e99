#include "edge_mcl/core/image/edge_thresholds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {
namespace {

TEST(EdgeThresholds, LevelsAreQuartersOfAnOctave) {
  for (int level = 0; level < EdgeThresholds::kLevels; ++level) {
    const uint32_t low = EdgeThresholds::lowestOf(level);
    const uint32_t high = EdgeThresholds::lowestOf(level + 1);
    EXPECT_EQ(EdgeThresholds::levelOf(low), level);
    EXPECT_EQ(EdgeThresholds::levelOf(high - 1), level);
    EXPECT_LE(high, std::max(low + 1.0, 1.25 * low));
  }
  // The largest gradient: Scharr's weights add up to 16.
  const double most = 16.0 * 255 * EdgeImage::kGradientScale;
  EXPECT_LT(EdgeThresholds::levelOf(static_cast<uint32_t>(2 * most * most)),
            EdgeThresholds::kLevels);
}

/// A board of strong squares at the left, a weak outline of a box at the right. Noise of one grey
/// level lies over both.
cv::Mat boardAndBox(double box_contrast) {
  cv::Mat image(480, 640, CV_8U, cv::Scalar(120));
  for (int y = 20; y + 12 <= 460; y += 24)
    for (int x = 20; x + 12 <= 360; x += 24)
      cv::rectangle(image, cv::Rect(x, y, 12, 12), cv::Scalar(10), cv::FILLED);
  cv::rectangle(image, cv::Rect(450, 150, 120, 160), cv::Scalar(120 + box_contrast), cv::FILLED);
  cv::Mat noise(image.size(), CV_16S), sum;
  cv::theRNG().state = 3;
  cv::randn(noise, 0, 1);
  image.convertTo(sum, CV_16S);
  sum += noise;
  sum.convertTo(image, CV_8U);
  return image;
}

/// Share of the outline of the box that has an edge within two pixels.
double outlineFound(const EdgeImage& edges) {
  cv::Mat near_edge;
  cv::dilate(edges.edges, near_edge, cv::Mat::ones(5, 5, CV_8U));
  int found = 0, all = 0;
  for (int x = 455; x < 565; ++x)
    for (const int y : {150, 310}) found += near_edge.at<uint8_t>(y, x) != 0, ++all;
  for (int y = 155; y < 305; ++y)
    for (const int x : {450, 570}) found += near_edge.at<uint8_t>(y, x) != 0, ++all;
  return static_cast<double>(found) / all;
}

TEST(EdgeThresholds, AWeakOutlineIsFoundBesideAStrongPattern) {
  const cv::Mat image = boardAndBox(16);
  ImageParameters one;
  one.contrast_window = 0;
  EXPECT_LT(outlineFound(findEdges(image, {}, one, "x")), 0.1);
  EXPECT_GT(outlineFound(findEdges(image, {}, {}, "x")), 0.95);
}

TEST(EdgeThresholds, NoiseBesideAStrongPatternIsNoEdge) {
  const EdgeImage edges = findEdges(boardAndBox(0), {}, {}, "x");
  EXPECT_LT(cv::countNonZero(edges.edges.colRange(440, 640)), 20);
}

/// Where the contrast is the same everywhere, the tiles have the threshold of the image.
TEST(EdgeThresholds, EvenContrastHasOneThreshold) {
  cv::Mat image(480, 640, CV_8U, cv::Scalar(60));
  for (int y = 0; y < 480; y += 24)
    for (int x = 0; x < 640; x += 24)
      cv::rectangle(image, cv::Rect(x, y, 12, 12), cv::Scalar(200), cv::FILLED);
  ImageParameters one;
  one.contrast_window = 0;
  const cv::Mat same = findEdges(image, {}, one, "x").edges == findEdges(image, {}, {}, "x").edges;
  EXPECT_EQ(cv::countNonZero(same), 480 * 640);
}

/// With one threshold the edges are those of OpenCV.
TEST(EdgeThresholds, OneThresholdIsCanny) {
  ImageParameters one;
  one.contrast_window = 0;
  for (int k = 0; k < 4; ++k) {
    cv::Mat image = boardAndBox(12);
    if (k == 1) image = image(cv::Rect(3, 5, 201, 97)).clone();
    if (k >= 2) cv::randu(image, 0, k == 2 ? 256 : 40);  // directions of every kind
    const EdgeImage found = findEdges(image, {}, one, "x");
    cv::Mat canny;
    cv::Canny(found.gradient_x, found.gradient_y, canny, one.hysteresis * found.strong_threshold,
              found.strong_threshold, true);
    EXPECT_EQ(cv::countNonZero(canny != found.edges), 0) << k;
  }
}

/// The edges against a slow reference: every pixel on its own, connected by repeated dilation.
TEST(EdgeThresholds, EdgesAreCandidatesConnectedToStrongOnes) {
  const cv::Mat image = boardAndBox(12);
  const ImageParameters params;
  const EdgeImage found = findEdges(image, {}, params, "x");
  const EdgeThresholds thresholds(found.gradient_x, found.gradient_y, {}, params,
                                  EdgeImage::kLeastThreshold);
  cv::Mat ridges;
  cv::Canny(found.gradient_x, found.gradient_y, ridges, 1, 1, true);
  cv::Mat weak = cv::Mat::zeros(image.size(), CV_8U), edges = weak.clone();
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const double square = std::pow(found.gradient_x.at<int16_t>(y, x), 2) +
                            std::pow(found.gradient_y.at<int16_t>(y, x), 2);
      if (!ridges.at<uint8_t>(y, x)) continue;
      if (square > thresholds.at(x, y).weak) weak.at<uint8_t>(y, x) = 255;
      if (square > thresholds.at(x, y).strong) edges.at<uint8_t>(y, x) = 255;
    }
  for (int count = -1; count != cv::countNonZero(edges);) {
    count = cv::countNonZero(edges);
    cv::Mat grown;
    cv::dilate(edges, grown, cv::Mat::ones(3, 3, CV_8U));
    edges = grown & weak;
  }
  EXPECT_EQ(cv::countNonZero(edges != found.edges), 0);
}

TEST(EdgeThresholds, ImagesSmallerThanATileAndMasksOfEverything) {
  cv::Mat tiny(5, 7, CV_8U, cv::Scalar(90));
  tiny.colRange(3, 7) = 200;
  EXPECT_NO_THROW(findEdges(tiny, {}, {}, "x"));
  ImageParameters params;
  params.mask_dilation = 0;
  const cv::Mat all(480, 640, CV_8U, cv::Scalar(255));
  EXPECT_EQ(findEdges(boardAndBox(12), all, params, "x").edgeCount(), 0u);
}

}  // namespace
}  // namespace edge_mcl
