#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "support/error_text.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

TEST(Conversions, PosesAndCamerasRoundTrip) {
  RandomSource random(31);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = expSe3(random.normalTwist());
    EXPECT_LT((toPose(toMrpt(pose)).matrix() - pose.matrix()).norm(), 1e-9);
    EXPECT_LT((toPose(toMrpt(pose).asTPose()).matrix() - pose.matrix()).norm(), 1e-9);
  }
  CameraModel camera = test::pinhole();
  camera.distortion = DistortionModel::kEquidistant;
  camera.coefficients = {0.02, -0.01, 0.003, -0.001};
  camera.validate("x");
  const CameraModel back = toCameraModel(toMrpt(camera), "x");
  EXPECT_EQ(back.coefficients, camera.coefficients);
  EXPECT_EQ(back.distortion, camera.distortion);
}

TEST(Conversions, CovarianceKeepsTheSignOfCrossTerms) {
  // x and yaw have a positive or a negative correlation. The CPose3DPDFParticles of MRPT takes
  // absolute differences of angles and cannot tell the two apart.
  for (const double sign : {1.0, -1.0}) {
    PoseGaussian g;
    Twist d = Twist::Zero();
    d[0] = 0.1;
    d[5] = sign * 0.2;
    g.covariance = d * d.transpose();
    EXPECT_NEAR(toMrptCovariance(g)(0, 3), sign * 0.02, 1e-6);
  }
}

/// MRPT's angles are rotations about the fixed axes x (roll), y (pitch) and z (yaw), in this order.
TEST(Conversions, APoseHasItsPositionAndAngles) {
  const mrpt::poses::CPose3D mrpt_pose(1, 2, 3, 0.7, -0.4, 0.2);  // x, y, z, yaw, pitch, roll
  const Pose pose = toPose(mrpt_pose);
  EXPECT_EQ(pose.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((pose.linear() - rotationFromAngles(0.2, -0.4, 0.7)).norm(), 1e-12);
  const mrpt::poses::CPose3D back = toMrpt(pose);
  EXPECT_NEAR(back.yaw(), 0.7, 1e-12);
  EXPECT_NEAR(back.pitch(), -0.4, 1e-12);
  EXPECT_NEAR(back.roll(), 0.2, 1e-12);
}

TEST(Conversions, EveryCameraModelRoundTrips) {
  for (const DistortionModel model :
       {DistortionModel::kNone, DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial,
        DistortionModel::kEquidistant}) {
    const CameraModel camera = test::distorted(test::pinhole(), model);
    const CameraModel back = toCameraModel(toMrpt(camera), "camera");
    EXPECT_EQ(back.distortion, camera.distortion);
    EXPECT_EQ(back.coefficients, camera.coefficients);
    EXPECT_EQ(back.width, camera.width);
    EXPECT_EQ(back.height, camera.height);
    EXPECT_EQ(back.fx, camera.fx);
    EXPECT_EQ(back.fy, camera.fy);
    EXPECT_EQ(back.cx, camera.cx);
    EXPECT_EQ(back.cy, camera.cy);
    EXPECT_EQ(back.max_radius2, camera.max_radius2);
  }
}

/// MRPT names the coefficients k1, k2, p1, p2, k3.
TEST(Conversions, TheCoefficientsHaveTheirMeaning) {
  const mrpt::img::TCamera camera =
      toMrpt(test::distorted(test::pinhole(), DistortionModel::kPlumbBob));
  EXPECT_EQ(camera.k1(), -0.28);
  EXPECT_EQ(camera.k2(), 0.07);
  EXPECT_EQ(camera.p1(), 2e-4);
  EXPECT_EQ(camera.p2(), 2e-5);
  EXPECT_EQ(camera.k3(), 0);
}

TEST(Conversions, ACameraWithoutSizeOrFocalLengthIsAnError) {
  mrpt::img::TCamera camera = toMrpt(test::pinhole());
  camera.ncols = 0;
  test::expectError<InputError>("left camera", [&] { toCameraModel(camera, "left camera"); });
  camera = toMrpt(test::pinhole());
  camera.fx(0);
  test::expectError<InputError>("left camera", [&] { toCameraModel(camera, "left camera"); });
}

/// A level base that is turned by the yaw a. The covariance of its position is turned by a, and the
/// rotations about its axes x, y, z are roll, pitch and yaw.
TEST(Conversions, TheCovarianceOfALevelBaseAgreesWithItsClosedForm) {
  constexpr double kYaw = 0.6;
  PoseGaussian g;
  g.mean.linear() = rotationFromAngles(0, 0, kYaw);
  g.covariance.diagonal() << 0.04, 0.01, 0.09, 0.001, 0.002, 0.003;
  const auto c = toMrptCovariance(g);
  const double cosine = std::cos(kYaw), sine = std::sin(kYaw);
  // The derivatives come from differences with an error of about 1e-9.
  EXPECT_NEAR(c(0, 0), 0.04 * cosine * cosine + 0.01 * sine * sine, 1e-9);
  EXPECT_NEAR(c(1, 1), 0.04 * sine * sine + 0.01 * cosine * cosine, 1e-9);
  EXPECT_NEAR(c(0, 1), (0.04 - 0.01) * sine * cosine, 1e-9);
  EXPECT_NEAR(c(2, 2), 0.09, 1e-9);
  EXPECT_NEAR(c(3, 3), 0.003, 1e-9);  // yaw
  EXPECT_NEAR(c(4, 4), 0.002, 1e-9);  // pitch
  EXPECT_NEAR(c(5, 5), 0.001, 1e-9);  // roll
}

/// The truth is the spread of MRPT's coordinates over random poses. The yaw of 3.1 rad is near the
/// jump of the angle from pi to -pi.
TEST(Conversions, TheCovarianceAgreesWithRandomPoses) {
  RandomSource random(32);
  PoseGaussian g;
  g.mean.linear() = rotationFromAngles(0.3, -0.6, 3.1);
  Matrix6 root;
  for (int i = 0; i < 6; ++i) root.col(i) = 0.01 * random.normalTwist();
  g.covariance = root * root.transpose();
  constexpr int kPoses = 20000;
  Matrix6 sampled = Matrix6::Zero();
  for (int i = 0; i < kPoses; ++i) {
    const mrpt::poses::CPose3D p = toMrpt(g.mean * expSe3(root * random.normalTwist()));
    Twist d;
    d << p.x(), p.y(), p.z(), std::remainder(p.yaw() - 3.1, 2 * M_PI), p.pitch() + 0.6,
        p.roll() - 0.3;
    sampled += d * d.transpose() / kPoses;
  }
  const auto c = toMrptCovariance(g);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      // The error of a sample covariance is at most sqrt(2)/141 of the product of both deviations.
      // Five of these are allowed.
      EXPECT_NEAR(c(i, j), sampled(i, j), 5 * 1.42 / 141 * std::sqrt(c(i, i) * c(j, j)))
          << i << " " << j;
    }
}

}  // namespace
}  // namespace edge_mcl
