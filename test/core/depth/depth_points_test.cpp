#include "edge_mcl/core/depth/depth_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "support/depth_scenes.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::roomDepth;

/// Every point, projected by the camera model, must lie on a pixel that has its depth.
TEST(DepthPoints, ProjectBackToTheirPixels) {
  for (const DistortionModel model :
       {DistortionModel::kNone, DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial,
        DistortionModel::kEquidistant}) {
    DepthImage image;
    image.camera = test::distorted(test::pinhole(), model);
    image.depth = cv::Mat(480, 640, CV_16U);
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; ++x) image.depth.at<uint16_t>(y, x) = 1000 + 4 * x + y;
    const DepthPoints points = makeDepthPoints(image, DepthParameters());
    ASSERT_GT(points.count, 400u);
    EXPECT_LE(points.count, 500u);
    for (size_t i = 0; i < points.count; ++i) {
      Eigen::Vector2d pixel;
      ASSERT_TRUE(image.camera.project({points.x[i], points.y[i], points.z[i]}, &pixel));
      const int x = static_cast<int>(std::lround(pixel.x())),
                y = static_cast<int>(std::lround(pixel.y()));
      EXPECT_NEAR(pixel.x(), x, 1e-3);
      EXPECT_NEAR(pixel.y(), y, 1e-3);
      EXPECT_NEAR(points.z[i], image.depth.at<uint16_t>(y, x) / 1000.0, 1e-6);
    }
  }
}

/// Columns and rows of the depth image are missing, negative, infinite, too far or masked. No point
/// may come from them.
TEST(DepthPoints, WhatIsIgnoredOutOfRangeOrMissingIsLeftOut) {
  DepthImage image = roomDepth();
  DepthParameters params;
  params.max_range = 2.5;
  image.depth.colRange(0, 40).setTo(NAN);
  image.depth.rowRange(0, 10).setTo(-1);
  image.depth.rowRange(10, 15).setTo(INFINITY);
  image.mask = {cv::Mat::zeros(120, 160, CV_8U), image.camera, Pose::Identity()};
  image.mask->pixels.colRange(100, 160).setTo(255);
  const DepthPoints points = makeDepthPoints(image, params);
  ASSERT_GT(points.count, 20u);
  for (size_t i = 0; i < points.count; ++i) {
    Eigen::Vector2d pixel;
    ASSERT_TRUE(image.camera.project({points.x[i], points.y[i], points.z[i]}, &pixel));
    EXPECT_GT(pixel.x(), 39.5);
    EXPECT_LT(pixel.x(), 99.5);
    EXPECT_GT(pixel.y(), 14.5);
    EXPECT_LE(points.z[i], 2.5f);
  }
  image.mask->pixels.setTo(1);
  EXPECT_EQ(makeDepthPoints(image, params).count, 0u);
  image.mask.reset();
  image.depth.setTo(0);
  EXPECT_EQ(makeDepthPoints(image, params).count, 0u);
}

TEST(DepthPoints, TheMaskMayBeThatOfAnotherCamera) {
  DepthImage image = roomDepth();
  // The mask belongs to a colour camera 30 cm to the right. It masks the right half of this camera,
  // which is a half-space of the scene.
  const Eigen::Vector3d offset(0.3, 0, 0);
  DepthImage::Mask mask{cv::Mat::zeros(480, 640, CV_8U), test::pinhole(), Pose::Identity()};
  mask.T_mask_depth.translation() = -offset;
  mask.pixels.colRange(320, 640).setTo(1);
  image.mask = mask;
  const DepthPoints points = makeDepthPoints(image, DepthParameters());
  ASSERT_GT(points.count, 50u);
  for (size_t i = 0; i < points.count; ++i) {
    Eigen::Vector2d pixel;
    const Eigen::Vector3d seen = Eigen::Vector3d(points.x[i], points.y[i], points.z[i]) - offset;
    if (mask.camera.project(seen, &pixel) && mask.camera.contains(pixel)) {
      EXPECT_LT(pixel.x(), 319.6);
    }
  }
}

TEST(DepthPoints, BrokenImagesAreErrors) {
  DepthImage image = roomDepth();
  image.camera.width = 150;
  EXPECT_THROW(makeDepthPoints(image, DepthParameters()), InputError);
  image = roomDepth();
  image.depth.convertTo(image.depth, CV_8U);
  EXPECT_THROW(makeDepthPoints(image, DepthParameters()), InputError);
  image = roomDepth();
  image.mask = {cv::Mat::zeros(12, 16, CV_8U), image.camera, Pose::Identity()};
  EXPECT_THROW(makeDepthPoints(image, DepthParameters()), InputError);
}

/// Depth image of a wall that is perpendicular to the optical axis.
DepthImage wall(double metres) {
  DepthImage image;
  image.camera = test::pinhole(160, 120, 125);
  image.depth = cv::Mat(120, 160, CV_32F, cv::Scalar(metres));
  image.origin = "wall";
  return image;
}

TEST(DepthPoints, TheVarianceGrowsWithTheDepth) {
  DepthParameters params;
  const DepthPoints points = makeDepthPoints(roomDepth(), params);
  ASSERT_GT(points.count, 400u);
  double sum = 0;
  for (size_t i = 0; i < points.count; ++i) {
    const double noise = params.sigma_per_square_metre * points.z[i] * points.z[i];
    const double variance = params.sigma * params.sigma + noise * noise;
    EXPECT_NEAR(points.inverse_variance[i] * variance, 1, 1e-6);  // single precision
    sum += points.z[i];
  }
  EXPECT_NEAR(points.mean_depth, sum / static_cast<double>(points.count), 1e-6);
}

/// The vector unit needs whole blocks of 16 points. The points of the padding must have no weight.
TEST(DepthPoints, ArePaddedWithPointsOfNoWeight) {
  for (const int wanted : {10, 16, 17, 100, 500}) {
    DepthParameters params;
    params.points = wanted;
    const DepthPoints points = makeDepthPoints(wall(2), params);
    EXPECT_EQ(points.count, static_cast<size_t>(wanted));
    const size_t padded = (points.count + 15) / 16 * 16;
    for (const auto* v : {&points.x, &points.y, &points.z, &points.inverse_variance})
      ASSERT_EQ(v->size(), padded);
    for (size_t i = points.count; i < padded; ++i) EXPECT_EQ(points.inverse_variance[i], 0);
  }
}

/// The image is divided into 4 x 4 parts. Every part must have about a sixteenth of the points. The
/// examined pixels lie on a grid, so a part may have one row or column of them more or less (of
/// 13 x 10).
TEST(DepthPoints, AreSpreadEvenlyOverTheImage) {
  const DepthImage image = wall(2);
  const DepthPoints points = makeDepthPoints(image, DepthParameters());
  int parts[4][4] = {};
  for (size_t i = 0; i < points.count; ++i) {
    Eigen::Vector2d pixel;
    ASSERT_TRUE(image.camera.project({points.x[i], points.y[i], points.z[i]}, &pixel));
    ++parts[static_cast<int>(pixel.y()) / 30][static_cast<int>(pixel.x()) / 40];
  }
  for (const auto& row : parts)
    for (const int part : row) EXPECT_NEAR(part, 500 / 16.0, 0.2 * 500 / 16.0);
}

/// The depths 0.25, 0.5, ... 10 m come in stripes. The limits themselves are in range.
TEST(DepthPoints, OnlyDepthsInRangeAreTaken) {
  DepthImage image = wall(2);
  for (int x = 0; x < 160; ++x) {
    const int stripe = 1 + x / 4;
    image.depth.col(x).setTo(0.25 * stripe);
  }
  DepthParameters params;
  params.points = 100000;
  params.min_range = 1.5;
  params.max_range = 4.5;
  const DepthPoints points = makeDepthPoints(image, params);
  ASSERT_GT(points.count, 0u);
  EXPECT_EQ(*std::min_element(points.z.begin(), points.z.begin() + points.count), 1.5f);
  EXPECT_EQ(*std::max_element(points.z.begin(), points.z.begin() + points.count), 4.5f);
  // All pixels are examined. 13 of the 40 stripes are in range.
  EXPECT_EQ(points.count, 13u * 4 * 120);
  EXPECT_NEAR(points.returned, 13.0 / 40, 1e-12);
}

TEST(DepthPoints, SixteenBitsHaveAUnit) {
  DepthImage image = wall(2);
  image.depth = cv::Mat(120, 160, CV_16U, cv::Scalar(7500));
  image.units_per_metre = 5000;
  const DepthPoints points = makeDepthPoints(image, DepthParameters());
  ASSERT_GT(points.count, 0u);
  for (size_t i = 0; i < points.count; ++i) EXPECT_EQ(points.z[i], 1.5f);
}

/// Half of the columns have no depth, and the mask covers a quarter of the other ones.
TEST(DepthPoints, TheShareOfReturnsLeavesOutTheMask) {
  DepthImage image = wall(2);
  image.depth.colRange(0, 80).setTo(0);
  DepthParameters params;
  params.points = 100000;
  EXPECT_NEAR(makeDepthPoints(image, params).returned, 0.5, 1e-12);
  image.mask = {cv::Mat::zeros(120, 160, CV_8U), image.camera, Pose::Identity()};
  image.mask->pixels.colRange(80, 100).setTo(255);
  EXPECT_NEAR(makeDepthPoints(image, params).returned, 60.0 / 140, 1e-12);
}

/// The pixels under the mask have no depth, as with a propeller close to the camera. All pixels
/// outside the mask have one, so the share is 1. Pixels without depth are never compared with the
/// mask, so they count as examined pixels outside the mask.
TEST(DepthPoints, DISABLED_MaskedPixelsWithoutDepthDoNotCount) {
  DepthImage image = wall(2);
  image.depth.colRange(0, 80).setTo(0);
  image.mask = {cv::Mat::zeros(120, 160, CV_8U), image.camera, Pose::Identity()};
  image.mask->pixels.colRange(0, 80).setTo(255);
  EXPECT_NEAR(makeDepthPoints(image, DepthParameters()).returned, 1, 1e-12);
}

/// A sensor with the bias b reads z - b z^2. The correction is of first order: what remains is at
/// most 2 b^2 z^3, which is 0.5 mm at 4 m. The points must stay on the rays of their pixels.
TEST(WithoutBias, TheTrueDepthsComeBack) {
  constexpr double kBias = 0.002;
  for (const double z : {0.5, 2.0, 4.0}) {
    const DepthPoints read = makeDepthPoints(wall(z - kBias * z * z), DepthParameters());
    const DepthPoints points = withoutBias(read, {kBias, 0});
    ASSERT_EQ(points.count, read.count);
    for (size_t i = 0; i < points.count; ++i) {
      EXPECT_NEAR(points.z[i], z, 2 * kBias * kBias * z * z * z + 1e-6);  // single precision
      EXPECT_NEAR(points.x[i] / points.z[i], read.x[i] / read.z[i], 1e-6);
      EXPECT_NEAR(points.y[i] / points.z[i], read.y[i] / read.z[i], 1e-6);
    }
  }
}

/// An error e of b moves a point by e z^2 along its ray. Its variance is added to the variance of
/// the point.
TEST(WithoutBias, TheUncertaintyOfTheBiasIsAdded) {
  constexpr double kVariance = 0.003 * 0.003;
  const DepthPoints before = makeDepthPoints(roomDepth(), DepthParameters());
  const DepthPoints after = withoutBias(before, {0, kVariance});
  EXPECT_EQ(after.bias_variance, kVariance);
  EXPECT_EQ(after.z, before.z);
  for (size_t i = 0; i < before.count; ++i) {
    const double added = kVariance * std::pow(before.z[i], 4);
    EXPECT_NEAR(1 / after.inverse_variance[i], 1 / before.inverse_variance[i] + added,
                1e-6 / before.inverse_variance[i] + 1e-6 * added);  // single precision
  }
  for (size_t i = before.count; i < before.x.size(); ++i) EXPECT_EQ(after.inverse_variance[i], 0);
}

TEST(WithoutBias, NoBiasChangesNothing) {
  const DepthPoints before = makeDepthPoints(roomDepth(), DepthParameters());
  const DepthPoints after = withoutBias(before, {});
  EXPECT_EQ(after.x, before.x);
  EXPECT_EQ(after.y, before.y);
  EXPECT_EQ(after.z, before.z);
  EXPECT_EQ(after.returned, before.returned);
  EXPECT_EQ(after.bias_variance, 0);
}

}  // namespace
}  // namespace edge_mcl
