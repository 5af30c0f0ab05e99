#include "edge_mcl/core/camera/camera_model.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/calib3d.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

CameraModel withDistortion(const std::string& model, const std::vector<double>& d) {
  const std::array<double, 9> k{460, 0, 370, 0, 455, 245, 0, 0, 1};
  return CameraModel::fromFields(752, 480, k, model, d.data(), d.size(), "test");
}

class Projection : public testing::TestWithParam<std::pair<const char*, std::vector<double>>> {};

/// The truth is the projection of the same point by OpenCV, for every distortion model.
TEST_P(Projection, AgreesWithOpenCv) {
  const auto& [model, d] = GetParam();
  const CameraModel camera = withDistortion(model, d);
  RandomSource random(5);
  const cv::Matx33d k(460, 0, 370, 0, 455, 245, 0, 0, 1);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p(random.normal(), random.normal(), 2 + 2 * random.uniform());
    Eigen::Vector2d pixel;
    if (!camera.project(p, &pixel) || !camera.contains(pixel)) continue;
    const std::vector<cv::Point3d> points{{p.x(), p.y(), p.z()}};
    std::vector<cv::Point2d> expected;
    const cv::Vec3d zero(0, 0, 0);
    if (camera.distortion == DistortionModel::kEquidistant)
      cv::fisheye::projectPoints(points, expected, zero, zero, k, d);
    else
      cv::projectPoints(points, zero, zero, k, d, expected);
    EXPECT_NEAR(pixel.x(), expected[0].x, 1e-9);
    EXPECT_NEAR(pixel.y(), expected[0].y, 1e-9);
  }
}

/// The truth is the central difference of the projection.
TEST_P(Projection, JacobianAgreesWithDifferences) {
  const CameraModel camera = withDistortion(GetParam().first, GetParam().second);
  RandomSource random(6);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p(0.8 * random.normal(), 0.6 * random.normal(), 1.5 + random.uniform());
    Eigen::Vector2d pixel, up, down;
    Eigen::Matrix<double, 2, 3> jacobian;
    if (!camera.project(p, &pixel, &jacobian) || !camera.contains(pixel)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d h = 1e-6 * Eigen::Vector3d::Unit(axis);
      ASSERT_TRUE(camera.project(p + h, &up) && camera.project(p - h, &down));
      // Central differences of a smooth function have an error of order h^2, plus rounding / h.
      EXPECT_LT((jacobian.col(axis) - (up - down) / 2e-6).norm(), 1e-4);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Models, Projection,
    testing::Values(
        std::make_pair("none", std::vector<double>{0, 0, 0, 0, 0}),
        std::make_pair("plumb_bob", std::vector<double>{-0.283, 0.074, 2e-4, 2e-5, 0}),
        std::make_pair("rational_polynomial",
                       std::vector<double>{0.2, -0.1, 1e-3, -5e-4, 0.01, 0.4, -0.05, 0.02}),
        std::make_pair("equidistant", std::vector<double>{0.02, -0.01, 0.003, -0.001})));

TEST(CameraModel, PointsBeyondTheMonotonePartDoNotFoldBack) {
  const CameraModel camera = withDistortion("plumb_bob", {-0.3, 0, 0, 0, 0});
  // The distorted radius r (1 - 0.3 r^2) grows up to r = 1.054. At r = 1.8 it is nearly zero again,
  // so this point would appear near the centre of the image.
  Eigen::Vector2d pixel;
  EXPECT_TRUE(camera.project({1.0, 0, 1}, &pixel));
  EXPECT_FALSE(camera.project({1.8, 0, 1}, &pixel));
  EXPECT_FALSE(camera.project({0, 0, -1}, &pixel));
}

TEST(CameraModel, BeyondAPoleOfTheRationalModelNothingIsSeen) {
  // The factor 1 / (1 - 0.01 r^6) has a pole at r = 2.15. Beyond it the factor is negative, so
  // points would appear mirrored.
  const CameraModel camera = withDistortion("rational_polynomial", {0, 0, 0, 0, 0, 0, 0, -0.01});
  Eigen::Vector2d pixel;
  EXPECT_TRUE(camera.project({0.5, 0, 1}, &pixel));
  EXPECT_FALSE(camera.project({2.8, 0, 1}, &pixel));
  EXPECT_FALSE(camera.project({4.3, 0, 1}, &pixel));
}

/// Every direction that projects into the image must lie in the cone of the angle `view.angle`. The
/// test tries directions over a half sphere and takes the widest one.
TEST(CameraModel, WhatIsProjectedLiesInTheConeOfTheView) {
  CameraModel camera = withDistortion("equidistant", {0, 0, 0, 0});
  camera.fx = camera.fy = 180;
  camera.validate("wide");
  double widest = 0;
  for (int i = 0; i < 360; ++i)
    for (double angle = 0; angle < M_PI / 2; angle += 0.002) {
      const double a = i * M_PI / 180;
      Eigen::Vector2d pixel;
      if (camera.project(
              {std::sin(angle) * std::cos(a), std::sin(angle) * std::sin(a), std::cos(angle)},
              &pixel) &&
          camera.contains(pixel))
        widest = std::max(widest, angle);
    }
  EXPECT_GT(widest, 1.5);
  EXPECT_LE(widest, camera.view.angle);
}

TEST(CameraModel, AMissingKeyIsNamed) {
  const std::string file = testing::TempDir() + "camera_missing_key.yaml";
  std::ofstream(file)
      << "image_width: 640\nimage_height: 480\n"
         "camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\n";
  try {
    CameraModel::fromYamlFile(file);
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("distortion_coefficients"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find(file), std::string::npos);
  }
  EXPECT_THROW(CameraModel::fromYamlFile("/does/not/exist.yaml"), InputError);
}

TEST(CameraModel, BadNumbersAreListed) {
  CameraModel camera = test::pinhole();
  camera.fx = NAN;
  camera.height = 0;
  try {
    camera.validate("x");
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("fx"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("size"), std::string::npos);
  }
}

}  // namespace
}  // namespace edge_mcl
