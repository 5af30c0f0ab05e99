#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/image/image_edges.h"
#include "edge_mcl/core/likelihood/score_table.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

// The kernels address the table with offsets of 32 bits. A larger table is an error.
TEST(ScoreTable, OneThatIsTooLargeIsRefused) {
  ScoreTable::checkSize(5472, 3648, 12);
  EXPECT_THROW(ScoreTable::checkSize(5472, 3648, 64), InputError);
  EXPECT_THROW(ScoreTable::checkSize(12000, 9000, 12), InputError);
}

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

/// The diamond angle grows with the angle. Both directions of a line have the same diamond angle.
/// diamondDirection() is its inverse.
TEST(EdgeField, DiamondAngleIsAMonotoneStandInForTheAngle) {
  double last = -1;
  for (int k = 0; k < 180; ++k) {
    const double p = diamondAngle(std::cos(k * M_PI / 180), std::sin(k * M_PI / 180));
    EXPECT_GT(p, last);
    last = p;
    EXPECT_NEAR(diamondAngle(-std::cos(k * M_PI / 180), -std::sin(k * M_PI / 180)), p, 1e-12);
    const Eigen::Vector2d d = diamondDirection(p);
    EXPECT_NEAR(std::abs(d.x() * std::sin(k * M_PI / 180) - d.y() * std::cos(k * M_PI / 180)), 0,
                1e-9);
  }
}

/// The list of edge pixels is compared with the edge image. Its search along the normal is compared
/// with searchAlongNormal(), which follows the paper step by step.
TEST(EdgePixels, FindWhatTheDirectSearchFinds) {
  const MeshModel mesh = test::furnishedRooms();
  const cv::Mat picture = test::render(mesh, test::pinhole(320, 240, 250),
                                       test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15}), 1);
  ImageParameters params;
  const EdgeImage image = findEdges(picture, {}, params, "room");
  const EdgePixels pixels(image);
  ASSERT_EQ(pixels.list().size(), image.edgeCount());
  for (const EdgePixel& p : pixels.list()) {
    ASSERT_NE(image.edges.at<uint8_t>(p.y, p.x), 0);
    const Eigen::Vector2d ridge = image.subPixel(p.x, p.y);
    ASSERT_NEAR(p.ridge_x, ridge.x(), 1e-4);  // single precision of numbers up to 320
    ASSERT_NEAR(p.ridge_y, ridge.y(), 1e-4);
  }
  const double tolerance = std::cos(params.orientation_tolerance_deg * M_PI / 180);
  RandomSource random(9);
  int differ = 0;
  constexpr int kSearches = 20000;
  for (int i = 0; i < kSearches; ++i) {
    const Eigen::Vector2d at(320 * random.uniform(), 240 * random.uniform());
    const double angle = M_PI * random.uniform();
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    const NormalHit hit = searchAlongNormal(image, at, normal, 16, tolerance);
    const EdgePixel* found = pixels.nearestAlong(
        static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(normal.x()),
        static_cast<float>(normal.y()), 16, static_cast<float>(tolerance));
    differ +=
        hit.found != (found != nullptr) || (hit.found && (hit.x != found->x || hit.y != found->y));
  }
  // A position within a thousandth of a pixel from the border of a pixel may be rounded to either
  // side. One search tests up to 64 positions, and few of them are on edges.
  EXPECT_LT(differ, kSearches / 100);
  EXPECT_EQ(pixels.nearestAlong(-100, -100, 1, 0, 16, 0), nullptr);
}

/// The table is compared with the direct search along the normal, in a picture of a furnished room.
TEST(EdgeField, AgreesWithTheDirectSearch) {
  const MeshModel mesh = test::furnishedRooms();
  const CameraModel camera = test::pinhole(320, 240, 250);
  const cv::Mat picture =
      test::render(mesh, camera, test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15}), 1);
  ImageParameters params;
  const EdgeImage image = findEdges(picture, {}, params, "room");
  ASSERT_GT(image.edgeCount(), 1000u);
  const EdgeField field(image, EdgePixels(image), params);
  const double tolerance = std::cos(params.orientation_tolerance_deg * M_PI / 180);
  RandomSource random(8);
  int good = 0, total = 0;
  for (int i = 0; i < 20000; ++i) {
    const int bin = static_cast<int>(random.uniform() * field.bins());
    const int x = static_cast<int>(random.uniform() * 320),
              y = static_cast<int>(random.uniform() * 240);
    const Eigen::Vector2d direction = diamondDirection(2.0 * bin / field.bins());
    const NormalHit hit =
        searchAlongNormal(image, Eigen::Vector2d(x, y), {-direction.y(), direction.x()},
                          params.search_length, tolerance);
    const double table = field.distance(bin, x, y);
    ++total;
    if (!hit.found && std::isinf(table))
      ++good;
    else if (hit.found && !std::isinf(table))
      good += std::abs(std::abs(hit.distance) - table) <= 1;
    else  // one of them finds no edge: rounding explains this at the end of the reach only
      good += (hit.found ? std::abs(hit.distance) : table) > params.search_length - 1.5;
  }
  std::printf("table agrees with the direct search within 1 px for %.2f %% of samples\n",
              100.0 * good / total);
  EXPECT_GT(good, 0.99 * total);
}

}  // namespace
}  // namespace edge_mcl
