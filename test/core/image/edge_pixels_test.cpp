#include "edge_mcl/core/image/edge_pixels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/image/edge_field.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// An image without edges whose gradients all point along x.
EdgeImage empty(int width, int height) {
  EdgeImage image;
  image.grey = cv::Mat(height, width, CV_8U, cv::Scalar(0));
  image.edges = cv::Mat(height, width, CV_8U, cv::Scalar(0));
  image.gradient_x = cv::Mat(height, width, CV_16S, cv::Scalar(100));
  image.gradient_y = cv::Mat(height, width, CV_16S, cv::Scalar(0));
  return image;
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

/// The truth is a plain walk through all pixels. Widths around multiples of eight are tried,
/// because the list is made from eight pixels at a time.
TEST(EdgePixels, AreListedByRowThenColumn) {
  RandomSource random(3);
  for (const int width : {1, 7, 8, 9, 15, 16, 37}) {
    for (const double share : {0.02, 0.5, 1.0}) {
      EdgeImage image = empty(width, 11);
      for (int y = 0; y < 11; ++y)
        for (int x = 0; x < width; ++x)
          image.edges.at<uint8_t>(y, x) = random.uniform() < share ? 255 : 0;
      const EdgePixels pixels(image);
      EXPECT_EQ(pixels.width(), width);
      EXPECT_EQ(pixels.height(), 11);
      size_t next = 0;
      for (int y = 0; y < 11; ++y)
        for (int x = 0; x < width; ++x) {
          if (image.edges.at<uint8_t>(y, x) == 0) continue;
          ASSERT_LT(next, pixels.list().size());
          EXPECT_EQ(pixels.list()[next].x, x);
          EXPECT_EQ(pixels.list()[next].y, y);
          ++next;
        }
      EXPECT_EQ(next, pixels.list().size());
    }
  }
}

TEST(EdgePixels, HaveTheUnitGradientAsNormal) {
  EdgeImage image = empty(20, 10);
  image.edges.at<uint8_t>(4, 6) = 255;
  image.gradient_x.at<int16_t>(4, 6) = -30;
  image.gradient_y.at<int16_t>(4, 6) = 40;
  image.edges.at<uint8_t>(7, 2) = 255;  // an edge pixel whose gradient vanishes
  image.gradient_x.at<int16_t>(7, 2) = 0;
  const EdgePixels pixels(image);
  ASSERT_EQ(pixels.list().size(), 2u);
  EXPECT_FLOAT_EQ(pixels.list()[0].normal_x, -0.6f);
  EXPECT_FLOAT_EQ(pixels.list()[0].normal_y, 0.8f);
  EXPECT_EQ(pixels.list()[1].normal_x, 0);
  EXPECT_EQ(pixels.list()[1].normal_y, 0);
}

/// Vertical edges lie at the columns 20 and 26. The distances are counted by hand.
TEST(EdgePixels, TheNearestEdgeWithinTheLengthIsFound) {
  EdgeImage image = empty(40, 10);
  image.edges.col(20) = 255;
  image.edges.col(26) = 255;
  const EdgePixels pixels(image);
  const auto columnFrom = [&](float u, float nx, float length) {
    const EdgePixel* found = pixels.nearestAlong(u, 5, nx, 0, length, 0.9f);
    return found ? found->x : -1;
  };
  for (const float nx : {1.0f, -1.0f}) {  // both sides are searched
    EXPECT_EQ(columnFrom(20, nx, 8), 20);
    EXPECT_EQ(columnFrom(22, nx, 8), 20);
    EXPECT_EQ(columnFrom(24, nx, 8), 26);
    EXPECT_EQ(columnFrom(31, nx, 8), 26);
    EXPECT_EQ(columnFrom(31, nx, 5), 26);
    EXPECT_EQ(columnFrom(31, nx, 4), -1);
    EXPECT_EQ(columnFrom(0, nx, 19), -1);
    EXPECT_EQ(columnFrom(0, nx, 20), 20);
  }
}

/// Edges of another direction are passed over. The nearer edge is horizontal, so its gradient is
/// perpendicular to the search.
TEST(EdgePixels, EdgesOfAnotherDirectionDoNotCount) {
  EdgeImage image = empty(40, 10);
  image.edges.col(20) = 255;
  image.edges.col(26) = 255;
  image.gradient_x.col(20) = 0;
  image.gradient_y.col(20) = 100;
  const EdgePixels pixels(image);
  const EdgePixel* found = pixels.nearestAlong(18, 5, 1, 0, 16, 0.9f);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->x, 26);
  // A tolerance of 90 degrees accepts every direction.
  EXPECT_EQ(pixels.nearestAlong(18, 5, 1, 0, 16, 0)->x, 20);
  // A gradient of 30 degrees to the normal is accepted up to this angle.
  image.gradient_x.col(26) = 866;
  image.gradient_y.col(26) = 500;
  const EdgePixels turned(image);
  const auto cosine = [](double degrees) {
    return static_cast<float>(std::cos(degrees * M_PI / 180));
  };
  EXPECT_NE(turned.nearestAlong(24, 5, 1, 0, 4, cosine(31)), nullptr);
  EXPECT_EQ(turned.nearestAlong(24, 5, 1, 0, 4, cosine(29)), nullptr);
}

TEST(EdgePixels, WithoutEdgesNothingIsFound) {
  const EdgePixels none(empty(40, 10));
  EXPECT_TRUE(none.list().empty());
  EXPECT_EQ(none.nearestAlong(20, 5, 1, 0, 200, 0), nullptr);
  const EdgePixels unset;
  EXPECT_EQ(unset.width(), 0);
  EXPECT_EQ(unset.nearestAlong(0, 0, 1, 0, 200, 0), nullptr);
}

}  // namespace
}  // namespace edge_mcl
