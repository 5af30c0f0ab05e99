#include "edge_mcl/core/image/image_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "support/error_text.h"

namespace edge_mcl {
namespace {

using test::contains;
using test::errorText;

/// Draws a dark disc of radius 60 around (100, 100) on a bright ground. A pixel on the border gets
/// the share of its area that the disc covers, by supersampling.
cv::Mat disc(double contrast, double brightness, double noise, uint64_t seed) {
  constexpr int kSize = 200, kSuper = 8;
  cv::Mat big(kSize * kSuper, kSize * kSuper, CV_32F);
  for (int y = 0; y < big.rows; ++y)
    for (int x = 0; x < big.cols; ++x) {
      const double u = (x + 0.5) / kSuper - 0.5, v = (y + 0.5) / kSuper - 0.5;
      big.at<float>(y, x) =
          static_cast<float>(brightness + (std::hypot(u - 100, v - 100) < 60 ? -contrast : 0));
    }
  cv::Mat image;
  cv::resize(big, image, cv::Size(kSize, kSize), 0, 0, cv::INTER_AREA);
  RandomSource random(seed);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      image.at<float>(y, x) += static_cast<float>(noise * random.normal());
  image.convertTo(image, CV_8U);
  return image;
}

/// The truth is the drawn circle. Edge pixels must lie on it by their sub-pixel positions, and
/// their normals must point along its radius.
TEST(ImageEdges, AreThinSubPixelExactAndDirected) {
  const EdgeImage image = findEdges(disc(80, 200, 0, 1), {}, {}, "disc");
  size_t count = 0;
  double worst = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      if (!image.edges.at<uint8_t>(y, x)) continue;
      ++count;
      const Eigen::Vector2d radial =
          (Eigen::Vector2d(x, y) - Eigen::Vector2d(100, 100)).normalized();
      EXPECT_GT(std::abs(radial.dot(image.normalAt(x, y))), std::cos(4 * M_PI / 180));
      worst =
          std::max(worst, std::abs((image.subPixel(x, y) - Eigen::Vector2d(100, 100)).norm() - 60));
    }
  // A circle that is one pixel wide has between 4 sqrt(2) r pixels (8-connected) and 8 r pixels
  // (4-connected).
  EXPECT_GT(count, 5.6 * 60);
  EXPECT_LT(count, 8.0 * 60);
  // Canny's pixel has an error of up to 0.7 px, the ridge a far smaller one.
  EXPECT_LT(worst, 0.35);
}

TEST(ImageEdges, TheCallersImageIsLeftAlone) {
  const cv::Mat image = disc(80, 200, 2, 6);
  const cv::Mat before = image.clone();
  const EdgeImage first = findEdges(image, {}, {}, "x"), second = findEdges(image, {}, {}, "x");
  EXPECT_EQ(cv::norm(image, before), 0);
  EXPECT_EQ(cv::norm(first.edges, second.edges), 0);
}

/// More than 320 of 360 points on the drawn circle must have an edge pixel within one pixel.
TEST(ImageEdges, DarkAndLowContrastImagesStillHaveEdges) {
  for (const auto& [contrast, brightness] : {std::pair{80.0, 200.0}, {12.0, 30.0}, {8.0, 120.0}}) {
    const EdgeImage image = findEdges(disc(contrast, brightness, 0.7, 2), {}, {}, "disc");
    size_t on_circle = 0;
    for (int k = 0; k < 360; ++k) {
      const int x = static_cast<int>(std::lround(100 + 60 * std::cos(k * M_PI / 180)));
      const int y = static_cast<int>(std::lround(100 + 60 * std::sin(k * M_PI / 180)));
      on_circle += cv::countNonZero(image.edges(cv::Rect(x - 1, y - 1, 3, 3))) > 0;
    }
    EXPECT_GT(on_circle, 320u) << "contrast " << contrast;
  }
}

/// In noise, fewer than one pixel in 50 may be an edge.
TEST(ImageEdges, UniformAndNoisyImagesHaveFew) {
  EXPECT_EQ(findEdges(cv::Mat(100, 100, CV_8U, cv::Scalar(0)), {}, {}, "black").edgeCount(), 0u);
  const EdgeImage noise = findEdges(disc(0, 120, 3, 3), {}, {}, "noise");
  EXPECT_LT(noise.edgeCount(), 200u * 200 / 50);
}

TEST(ImageEdges, NoiseOfAnyStrengthIsNoEdge) {
  // Weak noise that is rounded to whole grey levels leaves many pixels with equal values. The
  // detector must not take this for an even surface and the other pixels for edges.
  for (double sigma : {0.4, 0.7, 1.0, 1.4, 2.0, 3.0, 6.0})
    for (uint64_t seed = 1; seed <= 3; ++seed) {
      const EdgeImage noise = findEdges(disc(0, 60, sigma, seed), {}, {}, "noise");
      EXPECT_LT(noise.edgeCount(), 200u * 200 / 50) << "sigma " << sigma << ", seed " << seed;
    }
}

/// A mask that covers exactly the disc hides the outline of the disc, too. A mask of another size
/// or type is an error.
TEST(ImageEdges, TheMaskTakesTheOutlineOfAnObjectAlong) {
  cv::Mat mask(200, 200, CV_8U, cv::Scalar(0));
  cv::circle(mask, {100, 100}, 60, cv::Scalar(255), cv::FILLED);
  EXPECT_EQ(findEdges(disc(80, 200, 0, 4), mask, {}, "disc").edgeCount(), 0u);
  EXPECT_THROW(findEdges(disc(80, 200, 0, 4), cv::Mat(10, 10, CV_8U), {}, "disc"), InputError);
  EXPECT_THROW(findEdges(disc(80, 200, 0, 4), cv::Mat(200, 200, CV_32F), {}, "disc"), InputError);
}

/// The rectangle keeps its straight sides, the circle loses its edges.
TEST(ImageEdges, StraightSegmentsDropTheCircle) {
  ImageParameters params;
  params.straight_segments = true;
  params.min_segment_length = 40;  // arcs of this circle are straight to 1 px over 22 px only
  cv::Mat image = disc(80, 200, 0, 5);
  cv::rectangle(image, {5, 5}, {30, 190}, cv::Scalar(40), cv::FILLED);
  const EdgeImage all = findEdges(image, {}, {}, "x"), straight = findEdges(image, {}, params, "x");
  EXPECT_LT(straight.edgeCount(), all.edgeCount() - 100);
  EXPECT_GT(cv::countNonZero(straight.edges(cv::Rect(28, 20, 5, 150))), 130);
}

/// A picture of one grey value, with a noise of normal distribution.
cv::Mat noiseOf(int rows, int cols, double sigma, uint64_t seed) {
  RandomSource random(seed);
  cv::Mat image(rows, cols, CV_8U);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < cols; ++x)
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(60 + sigma * random.normal());
  return image;
}

/// The truth is the luminance of ITU-R BT.601: 0.299 red + 0.587 green + 0.114 blue. The result is
/// rounded, so its error is at most one grey level.
TEST(ToGrey, MixesColoursByLuminanceAndIgnoresTransparency) {
  RandomSource random(1);
  for (int i = 0; i < 100; ++i) {
    const int blue = static_cast<int>(256 * random.uniform());
    const int green = static_cast<int>(256 * random.uniform());
    const int red = static_cast<int>(256 * random.uniform());
    const int alpha = static_cast<int>(256 * random.uniform());
    const double luminance = 0.114 * blue + 0.587 * green + 0.299 * red;
    const cv::Mat three(1, 1, CV_8UC3, cv::Scalar(blue, green, red));
    const cv::Mat four(1, 1, CV_8UC4, cv::Scalar(blue, green, red, alpha));
    EXPECT_NEAR(toGrey(three, "x").at<uint8_t>(0, 0), luminance, 1);
    EXPECT_NEAR(toGrey(four, "x").at<uint8_t>(0, 0), luminance, 1);
  }
}

TEST(ToGrey, TakesTheHighByteOfSixteenBits) {
  cv::Mat wide(1, 256, CV_16U);
  for (int i = 0; i < 256; ++i) wide.at<uint16_t>(0, i) = static_cast<uint16_t>(256 * i);
  const cv::Mat grey = toGrey(wide, "x");
  ASSERT_EQ(grey.type(), CV_8UC1);
  for (int i = 0; i < 256; ++i) EXPECT_EQ(grey.at<uint8_t>(0, i), i);
  cv::Mat colour;
  cv::merge(std::vector<cv::Mat>{wide, wide, wide}, colour);
  EXPECT_LE(cv::norm(toGrey(colour, "x"), grey, cv::NORM_INF), 1);  // rounding of the three weights
}

/// Other code reads the grey image as one block of memory.
TEST(ToGrey, APartOfALargerImageBecomesOneBlock) {
  const cv::Mat large = noiseOf(40, 50, 20, 2);
  const cv::Mat part = large(cv::Rect(7, 5, 20, 10));
  const cv::Mat grey = toGrey(part, "x");
  EXPECT_TRUE(grey.isContinuous());
  EXPECT_EQ(cv::norm(grey, part, cv::NORM_INF), 0);
}

TEST(ToGrey, OtherImagesAreErrorsThatNameTheirOrigin) {
  const auto textOf = [](const cv::Mat& image) {
    return errorText<InputError>([&] { toGrey(image, "left camera"); });
  };
  EXPECT_EQ(textOf(cv::Mat()), "left camera: the image is empty");
  EXPECT_TRUE(contains(textOf(cv::Mat(4, 4, CV_32F)), "only 8- and 16-bit images"));
  EXPECT_TRUE(contains(textOf(cv::Mat(4, 4, CV_8S)), "only 8- and 16-bit images"));
  EXPECT_TRUE(contains(textOf(cv::Mat(4, 4, CV_8UC2)), "left camera: an image with 2 channels"));
  EXPECT_TRUE(contains(textOf(cv::Mat(4, 4, CV_16UC2)), "2 channels"));
}

/// The truth is the Gaussian in double precision. Weights are differences of two rounded sums, so
/// they have an error of at most one unit.
TEST(BlurWeights, AreARoundedGaussianWithAFixedSum) {
  for (const double sigma : {0.3, 0.5, 0.8, 1.0, 1.5, 2.0, 3.7, 8.0, 19.9}) {
    const std::vector<int> weights = blurWeights(sigma);
    EXPECT_EQ(2 * std::accumulate(weights.begin(), weights.end(), 0) - weights[0], kBlurUnit);
    double total = 0;
    for (int i = -200; i <= 200; ++i) total += std::exp(-0.5 * i * i / (sigma * sigma));
    for (int i = 0; i <= 200; ++i) {
      const double gaussian = kBlurUnit * std::exp(-0.5 * i * i / (sigma * sigma)) / total;
      const int weight = i < static_cast<int>(weights.size()) ? weights[i] : 0;
      EXPECT_GE(weight, 0) << sigma;
      EXPECT_NEAR(weight, gaussian, 1) << "sigma " << sigma << ", neighbour " << i;
    }
  }
}

TEST(BlurWeights, WithoutSmoothingThereIsOnlyThePixelItself) {
  EXPECT_EQ(blurWeights(0), std::vector<int>{kBlurUnit});
}

/// The mask has one pixel. The truth is the disc around this pixel. The border of a digital disc
/// may have an error of one pixel.
TEST(IgnoredPixels, TheMaskGrowsByADisc) {
  ImageParameters params;
  cv::Mat mask(60, 80, CV_8U, cv::Scalar(0));
  mask.at<uint8_t>(25, 40) = 1;
  for (const int dilation : {1, 5, 12}) {
    params.mask_dilation = dilation;
    const cv::Mat ignored = ignoredPixels(mask, {80, 60}, params, "x");
    ASSERT_EQ(ignored.type(), CV_8UC1);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x) {
        const double distance = std::hypot(x - 40, y - 25);
        const int value = ignored.at<uint8_t>(y, x);
        if (distance > dilation && distance <= dilation + 1) continue;
        EXPECT_EQ(value, distance <= dilation ? 255 : 0) << x << ", " << y;
      }
  }
}

TEST(IgnoredPixels, WithoutDilationAreThePixelsOfTheMask) {
  ImageParameters params;
  params.mask_dilation = 0;
  cv::Mat mask(6, 8, CV_8U, cv::Scalar(0));
  mask.at<uint8_t>(2, 3) = 1;
  mask.at<uint8_t>(4, 7) = 200;
  const cv::Mat ignored = ignoredPixels(mask, {8, 6}, params, "x");
  EXPECT_EQ(cv::countNonZero(ignored), 2);
  EXPECT_EQ(ignored.at<uint8_t>(2, 3), 255);
  EXPECT_EQ(ignored.at<uint8_t>(4, 7), 255);
  EXPECT_EQ(mask.at<uint8_t>(2, 3), 1) << "the mask of the caller must not change";
  EXPECT_TRUE(ignoredPixels({}, {8, 6}, params, "x").empty());
}

TEST(IgnoredPixels, AWrongMaskIsAnErrorThatNamesBothSizes) {
  const auto textOf = [](const cv::Mat& mask) {
    return errorText<InputError>([&] { ignoredPixels(mask, {80, 60}, {}, "detector"); });
  };
  EXPECT_EQ(textOf(cv::Mat(30, 40, CV_8U)),
            "detector: the mask has 40x30 pixels, the image has 80x60");
  EXPECT_TRUE(contains(textOf(cv::Mat(60, 80, CV_8UC3)), "the mask must be 8-bit grey"));
}

/// A ramp that rises by s grey levels per pixel has the same gradient everywhere, and smoothing
/// does not change it. Scharr's operator (3, 10, 3) times the central difference gives 16 * 2 s.
TEST(ImageEdges, TheGradientOfARampHasItsClosedForm) {
  cv::Mat ramp(60, 60, CV_8U);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) ramp.at<uint8_t>(y, x) = static_cast<uint8_t>(3 * x + y);
  for (const double sigma : {0.0, 1.0, 2.0}) {
    ImageParameters params;
    params.blur_sigma = sigma;
    const EdgeImage image = findEdges(ramp, {}, params, "ramp");
    const int reach =
        static_cast<int>(blurWeights(sigma).size());  // the border is repeated outside
    for (int y = reach; y < 60 - reach; ++y)
      for (int x = reach; x < 60 - reach; ++x) {
        ASSERT_EQ(image.gradient_x.at<int16_t>(y, x), 3 * 32 * EdgeImage::kGradientScale);
        ASSERT_EQ(image.gradient_y.at<int16_t>(y, x), 32 * EdgeImage::kGradientScale);
        // The unit gradient of the slope (3, 1).
        ASSERT_NEAR(image.normalAt(x, y).x(), 3 / std::sqrt(10.0), 1e-12);
        ASSERT_NEAR(image.normalAt(x, y).y(), 1 / std::sqrt(10.0), 1e-12);
      }
  }
}

/// The largest gradient that an image can have must fit into 16 bits: 16 * 255 * kGradientScale.
TEST(ImageEdges, TheStepFromBlackToWhiteDoesNotOverflow) {
  ImageParameters params;
  params.blur_sigma = 0;
  cv::Mat step(20, 20, CV_8U, cv::Scalar(0));
  step.colRange(10, 20).setTo(255);
  for (const bool rising : {true, false}) {
    const cv::Mat picture = rising ? step : 255 - step;
    const EdgeImage image = findEdges(picture, {}, params, "step");
    for (const int x : {9, 10})
      EXPECT_EQ(image.gradient_x.at<int16_t>(10, x),
                (rising ? 1 : -1) * 16 * 255 * EdgeImage::kGradientScale);
    EXPECT_EQ(image.gradient_x.at<int16_t>(10, 12), 0);
    EXPECT_EQ(image.normalAt(9, 10), Eigen::Vector2d(rising ? 1 : -1, 0));
    EXPECT_EQ(image.normalAt(3, 10), Eigen::Vector2d::Zero());
  }
}

/// The gradient magnitude is a parabola across the edge with its top at a known place. Its values
/// at pixels are whole numbers, so the top is found exactly.
TEST(ImageEdges, TheRidgeIsTheTopOfTheParabola) {
  EdgeImage image;
  image.grey = cv::Mat(20, 30, CV_8U, cv::Scalar(0));
  image.gradient_y = cv::Mat(20, 30, CV_16S, cv::Scalar(0));
  image.gradient_x = cv::Mat(20, 30, CV_16S, cv::Scalar(0));
  for (const double top : {9.6, 10.0, 10.3}) {
    for (int x = 0; x < 30; ++x)
      image.gradient_x.col(x).setTo(std::max(0L, std::lround(1000 - 100 * (x - top) * (x - top))));
    const Eigen::Vector2d ridge = image.subPixel(10, 7);
    EXPECT_NEAR(ridge.x(), top, 1e-12);
    EXPECT_NEAR(ridge.y(), 7, 1e-12);
  }
  // A plateau has no top, and the pixel itself is returned.
  image.gradient_x.setTo(500);
  EXPECT_EQ(image.subPixel(10, 7), Eigen::Vector2d(10, 7));
}

/// A texture of strong random gradients. The truth counts the pixels whose gradient exceeds the
/// threshold. The threshold is taken from a ninth of the 40,000 pixels, and a share measured on
/// 4,400 of them has a standard deviation of 0.005. The tolerance is four times as much, because
/// neighbouring gradients are correlated.
TEST(ImageEdges, TheGivenShareOfThePixelsExceedsTheThreshold) {
  ImageParameters params;
  params.noise_factor = 0;
  const cv::Mat texture = noiseOf(200, 200, 15, 3);
  for (const double share : {0.02, 0.08, 0.5, 0.9}) {
    params.edge_share = share;
    const EdgeImage image = findEdges(texture, {}, params, "texture");
    size_t above = 0;
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x)
        above += std::hypot(image.gradient_x.at<int16_t>(y, x),
                            image.gradient_y.at<int16_t>(y, x)) > image.strong_threshold;
    EXPECT_NEAR(static_cast<double>(above) / (200 * 200), share, 0.02);
  }
}

/// Twice the contrast gives twice the threshold. The smoothed image is rounded to an eighth of a
/// grey level, which changes thresholds by far less than 1 %.
TEST(ImageEdges, TheThresholdFollowsTheExposure) {
  ImageParameters params;
  params.noise_factor = 0;
  const cv::Mat dark = noiseOf(200, 200, 15, 4);
  const EdgeImage once = findEdges(dark, {}, params, "x");
  const EdgeImage twice = findEdges(2 * dark, {}, params, "x");
  ASSERT_GT(once.strong_threshold, EdgeImage::kLeastThreshold);
  EXPECT_NEAR(twice.strong_threshold / once.strong_threshold, 2, 0.02);
  EXPECT_EQ(findEdges(cv::Mat(50, 50, CV_8U, cv::Scalar(90)), {}, params, "x").strong_threshold,
            EdgeImage::kLeastThreshold);
}

/// The step between two grey values lies between the columns 29 and 30.
cv::Mat verticalStep() {
  cv::Mat step(40, 60, CV_8U, cv::Scalar(80));
  step.colRange(30, 60).setTo(160);
  return step;
}

/// Edges are thin: in every row the step has at most one pixel, on one side of the step. Its ridge
/// is the middle of the step. Gradients are whole numbers above 1000, so the ridge has an error of
/// less than 0.01 px.
TEST(ImageEdges, AStraightStepIsOnePixelWide) {
  const EdgeImage image = findEdges(verticalStep(), {}, {}, "step");
  EXPECT_EQ(image.width(), 60);
  EXPECT_EQ(image.height(), 40);
  EXPECT_GE(image.edgeCount(), 38u);  // a detector may leave out the first and the last row
  for (int y = 0; y < 39; ++y) {
    EXPECT_LE(cv::countNonZero(image.edges.row(y)), 1);
    for (int x = 0; x < 60; ++x) {
      if (!image.edges.at<uint8_t>(y, x)) continue;
      EXPECT_EQ(image.edges.at<uint8_t>(y, x), 255);
      EXPECT_TRUE(x == 29 || x == 30) << x;
      EXPECT_NEAR(image.subPixel(x, y).x(), 29.5, 0.01);
    }
  }
}

/// BUG: in the last row and in the last column of an image subPixel() returns the pixel itself. The
/// interpolation of the gradient takes these pixels for pixels outside the image.
TEST(ImageEdges, DISABLED_TheLastRowHasSubPixelPositionsToo) {
  const EdgeImage image = findEdges(verticalStep(), {}, {}, "step");
  ASSERT_EQ(cv::countNonZero(image.edges.row(39)), 1);
  const int x = image.edges.at<uint8_t>(39, 29) ? 29 : 30;
  EXPECT_NEAR(image.subPixel(x, 39).x(), 29.5, 0.01);
}

/// No edge lies inside the mask, and the edges outside it stay as they are.
TEST(ImageEdges, TheMaskTakesNothingElse) {
  ImageParameters params;
  params.noise_factor = 0;
  const cv::Mat texture = noiseOf(100, 120, 15, 5);
  cv::Mat mask(100, 120, CV_8U, cv::Scalar(0));
  mask(cv::Rect(50, 30, 20, 20)).setTo(1);
  const cv::Mat ignored = ignoredPixels(mask, texture.size(), params, "x");
  const EdgeImage image = findEdges(texture, mask, params, "x");
  EXPECT_EQ(cv::norm(image.ignore, ignored, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(image.edges & ignored), 0);
  EXPECT_GT(cv::countNonZero(image.edges), 100);
  const EdgeImage same = findEdgesOf(texture, ignored, params);
  EXPECT_EQ(cv::norm(image.edges, same.edges, cv::NORM_INF), 0);
  // With everything masked there is no pixel to take a threshold from.
  const EdgeImage none = findEdges(texture, cv::Mat(100, 120, CV_8U, cv::Scalar(9)), params, "x");
  EXPECT_EQ(none.edgeCount(), 0u);
  EXPECT_EQ(none.strong_threshold, EdgeImage::kLeastThreshold);
}

}  // namespace
}  // namespace edge_mcl
