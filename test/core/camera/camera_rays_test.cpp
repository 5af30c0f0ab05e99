#include "edge_mcl/core/camera/camera_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "support/error_text.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

constexpr DistortionModel kModels[] = {DistortionModel::kNone, DistortionModel::kPlumbBob,
                                       DistortionModel::kRationalPolynomial,
                                       DistortionModel::kEquidistant};

CameraModel withCoefficients(DistortionModel model, const std::array<double, 8>& coefficients,
                             double focal = 500) {
  CameraModel camera = test::pinhole(640, 480, focal);
  camera.fy = focal;
  camera.distortion = model;
  camera.coefficients = coefficients;
  camera.validate("test");
  return camera;
}

/// Pixel of a camera that lies at the given distorted radius to the right of the centre.
Eigen::Vector2d pixelAt(const CameraModel& camera, double distorted_radius) {
  return {camera.cx + camera.fx * distorted_radius, camera.cy};
}

TEST(Unproject, WithoutDistortionIsThePinhole) {
  const CameraModel camera = test::pinhole();
  RandomSource random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d pixel(640 * random.uniform(), 480 * random.uniform());
    Eigen::Vector2d ray;
    ASSERT_TRUE(unproject(camera, pixel, &ray));
    // The search stops at an error of 1e-7 pixels. The focal length is 500 pixels.
    EXPECT_LT((ray - test::plainRay(camera, pixel.x(), pixel.y()).head<2>()).norm(), 1e-7 / 500);
  }
}

/// The truth is the projection of the same ray by OpenCV. It must give the pixel again. OpenCV's
/// rational model is plumb_bob when the last three of its eight coefficients are 0.
TEST(Unproject, IsTheInverseOfTheProjectionOfOpenCv) {
  for (const DistortionModel model : kModels) {
    const CameraModel camera = test::distorted(test::pinhole(), model);
    const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
    const bool fisheye = model == DistortionModel::kEquidistant;
    const std::vector<double> d(camera.coefficients.begin(),
                                camera.coefficients.begin() + (fisheye ? 4 : 8));
    RandomSource random(2);
    const cv::Vec3d zero(0, 0, 0);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d pixel(640 * random.uniform(), 480 * random.uniform());
      Eigen::Vector2d ray;
      ASSERT_TRUE(unproject(camera, pixel, &ray));
      const std::vector<cv::Point3d> points{{ray.x(), ray.y(), 1}};
      std::vector<cv::Point2d> projected;
      if (fisheye)
        cv::fisheye::projectPoints(points, projected, zero, zero, k, d);
      else
        cv::projectPoints(points, zero, zero, k, d, projected);
      // The search stops at an error of 1e-7 pixels.
      EXPECT_NEAR(projected[0].x, pixel.x(), 2e-7);
      EXPECT_NEAR(projected[0].y, pixel.y(), 2e-7);
    }
  }
}

/// Without coefficients the radius in the image of a fisheye is the angle. The truth is the tangent
/// of the angle, up to 86 degrees.
TEST(Unproject, OfAFisheyeReachesNearlyNinetyDegrees) {
  const CameraModel camera = withCoefficients(DistortionModel::kEquidistant, {}, 200);
  for (double angle = 0.01; angle < 1.5; angle += 0.01) {
    Eigen::Vector2d ray;
    ASSERT_TRUE(unproject(camera, pixelAt(camera, angle), &ray)) << angle;
    // An error of 1e-7 pixels is 5e-10 radians. At 1.5 radians a radian is 200 units of X/Z.
    EXPECT_NEAR(ray.x(), std::tan(angle), 5e-10 * (1 + std::pow(std::tan(angle), 2)));
    EXPECT_NEAR(ray.y(), 0, 1e-7);
  }
  Eigen::Vector2d ray;
  EXPECT_FALSE(unproject(camera, pixelAt(camera, M_PI / 2), &ray));
}

/// The distorted radius r (1 - 0.3 r^2) grows up to 0.7027 at r = 1.054. No ray reaches a pixel
/// beyond it.
TEST(Unproject, BeyondTheLargestDistortedRadiusThereIsNoRay) {
  const CameraModel camera = withCoefficients(DistortionModel::kPlumbBob, {-0.3});
  Eigen::Vector2d ray;
  for (const double r : {0.1, 0.5, 0.9, 1.0}) {
    ASSERT_TRUE(unproject(camera, pixelAt(camera, r * (1 - 0.3 * r * r)), &ray)) << r;
    // An error of 1e-7 pixels is 2e-10. At r = 1 the distorted radius has the slope 0.1.
    EXPECT_NEAR(ray.x(), r, 1e-8);
  }
  EXPECT_FALSE(unproject(camera, pixelAt(camera, 0.71), &ray));
  EXPECT_FALSE(unproject(camera, pixelAt(camera, 2), &ray));
}

/// The distorted radius r (1 + r^2 - r^4) grows up to 1.040 at r = 0.916. So a pixel at the
/// distorted radius 1.0 has the ray r = 0.817. The search starts at r = 1.0, which is outside the
/// monotone part, and gives up.
TEST(Unproject, DISABLED_FindsARayThatIsNearerToTheCentreThanItsPixel) {
  const CameraModel camera = withCoefficients(DistortionModel::kPlumbBob, {1, -1});
  const double r = 0.817, distorted = r * (1 + r * r - r * r * r * r);
  ASSERT_GT(distorted, 0.95);
  Eigen::Vector2d ray;
  ASSERT_TRUE(unproject(camera, pixelAt(camera, distorted), &ray));
  EXPECT_NEAR(ray.x(), r, 1e-8);
}

/// The rays are stored in single precision, which has 24 bits.
constexpr double kRounding = 1.0 / (1 << 23);

TEST(CameraRays, AreTheRaysOfAllPixels) {
  for (const DistortionModel model : kModels) {
    const CameraModel camera = test::distorted(test::pinhole(64, 48, 50), model);
    const CameraRays rays(camera);
    ASSERT_EQ(rays.width(), 64);
    ASSERT_EQ(rays.height(), 48);
    for (int y = 0; y < 48; ++y)
      for (int x = 0; x < 64; ++x) {
        Eigen::Vector2d pixel;
        ASSERT_TRUE(camera.project({rays.at(x, y).x(), rays.at(x, y).y(), 1}, &pixel));
        // The focal length is 50 pixels, and the slope of the distortion is at most 2.
        EXPECT_LT((pixel - Eigen::Vector2d(x, y)).norm(), 2 * 50 * kRounding) << x << " " << y;
      }
  }
}

/// Without distortion the ray changes by 1 / focal length per pixel, also on the border of the
/// image.
TEST(CameraRays, SlopesOfAPinholeAreTheInverseFocalLengths) {
  const CameraModel camera = test::pinhole(32, 24, 40);
  const CameraRays rays(camera);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 32; ++x) {
      const CameraRays::Slope slope = rays.slopeAt(x, y);
      // Differences of numbers below 1 in single precision.
      EXPECT_LT((slope.by_x.cast<double>() - Eigen::Vector2d(1 / camera.fx, 0)).norm(), kRounding);
      EXPECT_LT((slope.by_y.cast<double>() - Eigen::Vector2d(0, 1 / camera.fy)).norm(), kRounding);
    }
}

/// The truth is the inverse of the derivative of the projection.
TEST(CameraRays, SlopesAreTheInverseOfTheProjection) {
  for (const DistortionModel model : kModels) {
    const CameraModel camera = test::distorted(test::pinhole(), model);
    const CameraRays rays(camera);
    for (int y = 5; y < 480; y += 47)
      for (int x = 5; x < 640; x += 63) {
        Eigen::Vector2d pixel;
        Eigen::Matrix<double, 2, 3> jacobian;
        const Eigen::Vector2f& ray = rays.at(x, y);
        ASSERT_TRUE(camera.project({ray.x(), ray.y(), 1}, &pixel, &jacobian));
        const CameraRays::Slope slope = rays.slopeAt(x, y);
        Eigen::Matrix2d product;
        product << jacobian.leftCols<2>() * slope.by_x.cast<double>(),
            jacobian.leftCols<2>() * slope.by_y.cast<double>();
        // The difference over two pixels has a rounding error of 500 * 2^-23 = 6e-5, and an error
        // of the third derivative over 500^2, which is smaller.
        EXPECT_LT((product - Eigen::Matrix2d::Identity()).norm(), 3e-4) << x << " " << y;
      }
  }
}

/// The focal length is chosen so that only the corners lie beyond the largest distorted radius
/// 0.7027 (see BeyondTheLargestDistortedRadiusThereIsNoRay). Their number is counted in the test.
TEST(CameraRays, PixelsWithoutARayAreNaN) {
  CameraModel camera = withCoefficients(DistortionModel::kPlumbBob, {-0.3}, 520);
  const CameraRays rays(camera);
  int without = 0;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      const double radius = std::hypot((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
      const bool is_nan = std::isnan(rays.at(x, y).x());
      EXPECT_EQ(is_nan, std::isnan(rays.at(x, y).y()));
      without += is_nan;
      // Half a pixel before the limit the slope of the projection is nearly 0. There the search may
      // end early.
      if (radius < 0.7027 - 1e-3) {
        EXPECT_FALSE(is_nan) << x << " " << y;
      }
      if (radius > 0.7028) {
        EXPECT_TRUE(is_nan) << x << " " << y;
      }
    }
  EXPECT_GT(without, 100);
}

/// With a shorter focal length more than a tenth of the pixels lies beyond the largest radius.
TEST(CameraRays, ADistortionWithoutInverseIsAnError) {
  const CameraModel camera = withCoefficients(DistortionModel::kPlumbBob, {-0.3}, 400);
  test::expectError<InputError>("no inverse", [&] { CameraRays rays(camera); });
}

}  // namespace
}  // namespace edge_mcl
