#include "edge_mcl/core/drawing/chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/random_source.h"
#include "support/painted.h"

namespace edge_mcl {
namespace {

ChartAxis axisOf(const std::vector<double>& values, double margin = 0, bool logarithmic = false) {
  ChartAxis axis("label", logarithmic);
  for (const double v : values) axis.include(v);
  axis.close(margin);
  return axis;
}

TEST(ChartAxis, GoesFromTheSmallestToTheLargestValue) {
  const ChartAxis axis = axisOf({6, 2, 3});
  EXPECT_DOUBLE_EQ(axis.at(2), 0);
  EXPECT_DOUBLE_EQ(axis.at(6), 1);
  EXPECT_DOUBLE_EQ(axis.at(3), 0.25);
  EXPECT_DOUBLE_EQ(axis.span(), 4);
  EXPECT_EQ(axis.label(), "label");
}

/// A quarter of the range is added on both sides: 2 to 6 becomes 1 to 7.
TEST(ChartAxis, AMarginWidensBothSides) {
  const ChartAxis axis = axisOf({2, 6}, 0.25);
  EXPECT_DOUBLE_EQ(axis.at(1), 0);
  EXPECT_DOUBLE_EQ(axis.at(7), 1);
}

/// 0.5 to 20 is widened to 0.1 to 100. Every power of ten has a third of the axis.
TEST(ChartAxis, ALogarithmicAxisGoesToFullPowersOfTen) {
  const ChartAxis axis = axisOf({20, 0.5}, 0, true);
  EXPECT_NEAR(axis.at(0.1), 0, 1e-12);
  EXPECT_NEAR(axis.at(1), 1 / 3.0, 1e-12);
  EXPECT_NEAR(axis.at(100), 1, 1e-12);
  EXPECT_NEAR(axis.span(), 3, 1e-12);
  const std::vector<double> ticks = axis.ticks();
  ASSERT_EQ(ticks.size(), 4u);
  for (size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(ticks[i] / std::pow(10, static_cast<double>(i) - 1), 1, 1e-12);
}

TEST(ChartAxis, ALogarithmicAxisHasNoZero) {
  const ChartAxis axis = axisOf({0, -5, 1}, 0, true);
  EXPECT_NEAR(axis.at(1e-4), 0, 1e-12);
  EXPECT_EQ(axis.at(0), axis.at(1e-4));
  EXPECT_NEAR(axis.at(1), 1, 1e-12);
}

/// With one value, or with none, an axis still has a length, so that nothing is divided by zero.
TEST(ChartAxis, OneValueOrNoneIsInTheMiddle) {
  for (const double value : {0.0, 5.0, -1e4}) {
    const ChartAxis axis = axisOf({value});
    EXPECT_GT(axis.span(), 0);
    EXPECT_NEAR(axis.at(value), 0.5, 1e-9);
  }
  EXPECT_NEAR(axisOf({}).at(0), 0.5, 1e-12);
  EXPECT_GT(axisOf({10}, 0, true).span(), 0.9);
}

TEST(ChartAxis, IsEnlargedAboutItsMiddle) {
  ChartAxis axis = axisOf({2, 6});
  axis.setSpan(10);
  EXPECT_DOUBLE_EQ(axis.at(4), 0.5);
  EXPECT_DOUBLE_EQ(axis.at(-1), 0);
  EXPECT_DOUBLE_EQ(axis.at(9), 1);
}

/// Random ranges of all sizes. A label is round when it is a whole multiple of 1, 2 or 5 times a
/// power of ten. Labels must be evenly spaced, within the axis, and neither too few nor too many.
TEST(ChartAxis, LabelsAreRoundAndEvenlySpaced) {
  RandomSource random(1);
  for (int i = 0; i < 500; ++i) {
    const double size = std::pow(10, 8 * random.uniform() - 4);
    const double low = size * 3 * random.normal(), high = low + size;
    const ChartAxis axis = axisOf({low, high});
    const std::vector<double> ticks = axis.ticks();
    ASSERT_GE(ticks.size(), 3u) << low << " to " << high;
    ASSERT_LE(ticks.size(), 10u) << low << " to " << high;
    const double step = ticks[1] - ticks[0];
    const double digit = step / std::pow(10, std::floor(std::log10(step) + 1e-6));
    EXPECT_TRUE(std::abs(digit - 1) < 1e-6 || std::abs(digit - 2) < 1e-6 ||
                std::abs(digit - 5) < 1e-6)
        << step;
    for (size_t k = 0; k < ticks.size(); ++k) {
      EXPECT_NEAR(ticks[k] - ticks[0], static_cast<double>(k) * step, 1e-9 * size);
      EXPECT_NEAR(ticks[k] / step, std::round(ticks[k] / step), 1e-6);
      EXPECT_GE(axis.at(ticks[k]), -1e-6);
      EXPECT_LE(axis.at(ticks[k]), 1 + 1e-6);
      EXPECT_TRUE(ticks[k] == 0 || std::abs(ticks[k]) > 0.5 * step) << "not quite zero";
    }
  }
}

/// The ends of the axes are the corners of the inner area. The y axis points up.
TEST(Chart, TheAxesEndAtTheCornersOfTheInnerArea) {
  const cv::Rect area(30, 20, 400, 300);
  const Chart chart(area, "title", axisOf({0, 10}), axisOf({-2, 2}));
  const cv::Rect inner = chart.inner();
  EXPECT_EQ(inner & area, inner) << "the inner area lies within the area";
  EXPECT_GT(inner.width, 250);
  EXPECT_GT(inner.height, 150);
  EXPECT_EQ(chart.at(0, -2), cv::Point(inner.x, inner.br().y));
  EXPECT_EQ(chart.at(10, 2), cv::Point(inner.br().x, inner.y));
  const cv::Point middle = chart.at(5, 0);
  EXPECT_NEAR(middle.x, inner.x + inner.width / 2.0, 1);
  EXPECT_NEAR(middle.y, inner.y + inner.height / 2.0, 1);
}

/// A square on the map is a square in the picture, whichever axis has the longer range. Its corners
/// are rounded to pixels.
TEST(Chart, WithEqualScaleASquareIsASquare) {
  for (const auto& [width, height] : {std::pair{100.0, 3.0}, {3.0, 100.0}}) {
    const Chart chart({0, 0, 400, 300}, "title", axisOf({0, width}), axisOf({0, height}), true);
    const cv::Point low = chart.at(0, 0), high = chart.at(3, 3);
    EXPECT_NEAR(high.x - low.x, low.y - high.y, 1);
    EXPECT_TRUE((chart.inner() + cv::Size(1, 1)).contains(chart.at(width, height)));
    EXPECT_TRUE((chart.inner() + cv::Size(1, 1)).contains(low));
  }
}

/// The frame, the grid and all labels stay in the area. The labels at the ends of the axes are the
/// most likely to leave it.
TEST(Chart, TheFrameIsPaintedWithinItsArea) {
  for (const double range : {1.0, 1000.0, 123456.0}) {
    cv::Mat picture = test::whitePaper(560, 420);
    const cv::Rect area(80, 60, 400, 300);
    const Chart chart(area, "a title", axisOf({0, range}), axisOf({-range, range}));
    chart.drawFrame(&picture);
    const cv::Mat painted = test::paintedPixels(picture);
    EXPECT_EQ(test::bounds(painted) & area, test::bounds(painted)) << test::bounds(painted);
    // The border of the inner area is painted, and above it there is the title.
    const cv::Rect inner = chart.inner();
    EXPECT_NE(painted.at<uint8_t>(inner.y, inner.x + inner.width / 3), 0);
    EXPECT_NE(painted.at<uint8_t>(inner.y + inner.height / 3, inner.x), 0);
    EXPECT_GT(cv::countNonZero(painted(cv::Rect(area.x, area.y, area.width, inner.y - area.y))),
              50);
    // Below and to the left there are labels.
    EXPECT_GT(cv::countNonZero(painted(
                  cv::Rect(area.x, inner.br().y + 2, area.width, area.br().y - inner.br().y - 2))),
              50);
    EXPECT_GT(
        cv::countNonZero(painted(cv::Rect(area.x, inner.y, inner.x - area.x - 1, inner.height))),
        50);
  }
}

TEST(SeriesColour, HasEightColoursThatRepeat) {
  for (size_t a = 0; a < 8; ++a) {
    EXPECT_EQ(seriesColour(a), seriesColour(a + 8));
    for (size_t b = 0; b < a; ++b) EXPECT_GT(cv::norm(seriesColour(a) - seriesColour(b)), 50);
  }
}

cv::Mat markOf(size_t series, int radius) {
  cv::Mat picture = test::whitePaper(41, 41);
  drawMark(&picture, {20, 20}, series, cv::Scalar(200, 0, 0), radius);
  return picture;
}

/// The nine shapes differ in many pixels, so that they can be told apart without colour.
TEST(DrawMark, HasNineShapesThatRepeat) {
  for (size_t a = 0; a < 9; ++a) {
    EXPECT_EQ(cv::norm(markOf(a, 5), markOf(a + 9, 5), cv::NORM_INF), 0);
    for (size_t b = 0; b < a; ++b) {
      const cv::Mat differ = test::paintedPixels(markOf(a, 5)) != test::paintedPixels(markOf(b, 5));
      EXPECT_GT(cv::countNonZero(differ), 10) << a << " and " << b;
    }
  }
}

/// Smoothing and the width of strokes may add two pixels to the radius.
TEST(DrawMark, IsPaintedAroundItsCentre) {
  for (const int radius : {2, 5, 9})
    for (size_t series = 0; series < 9; ++series) {
      const cv::Mat picture = markOf(series, radius);
      const cv::Rect painted = test::bounds(test::paintedPixels(picture));
      EXPECT_GE(painted.width, 2 * radius - 1) << series;
      EXPECT_GE(painted.x, 20 - radius - 2) << series;
      EXPECT_GE(painted.y, 20 - radius - 2) << series;
      EXPECT_LE(painted.br().x, 20 + radius + 3) << series;
      EXPECT_LE(painted.br().y, 20 + radius + 3) << series;
      EXPECT_GT(cv::countNonZero(test::pixelsOf(picture, cv::Scalar(200, 0, 0))), 0) << series;
    }
}

}  // namespace
}  // namespace edge_mcl
