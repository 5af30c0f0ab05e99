#include "edge_mcl/localization/filter/motion_noise.h"

#include <gtest/gtest.h>

#include <vector>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

Twist twist(double x, double y, double z, double rx, double ry, double rz) {
  return (Twist() << x, y, z, rx, ry, rz).finished();
}

/// A tilted pose and a step with a rotation, so that no axis of the two agrees.
const Pose kPose = expSe3(twist(1, 2, 3, 0.3, -0.2, 1.1));
const Pose kStep = expSe3(twist(0.4, -0.1, 0.2, 0.1, 0.3, -0.2));

TEST(OdometryNoise, VariancesOfTimeAndMotionAddUp) {
  FilterParameters p;
  p.odometry_noise_position = 0.02;
  p.odometry_noise_angle_deg = 0.5;
  p.odometry_noise_per_metre = 0.1;
  p.odometry_noise_per_radian = 0.25;
  Pose step = Pose::Identity();
  step.translation() = Eigen::Vector3d(0, 3, 4);
  step.linear() = Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitY()).toRotationMatrix();
  // In 0.4 s the noise of 0.1 s doubles. The distance is 5 m, the angle is 0.8 rad.
  const Vector6 sigma = odometryNoise(p, step, 0.4);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(sigma[i] * sigma[i], 4 * 0.02 * 0.02 + 0.1 * 0.1 * 5, 1e-12);
  const double turn = 0.5 * M_PI / 180;
  for (int i = 3; i < 6; ++i)
    EXPECT_NEAR(sigma[i] * sigma[i], 4 * turn * turn + 0.25 * 0.25 * 0.8, 1e-12);
}

/// A metre at 5 images a second has the same noise as at 50.
TEST(OdometryNoise, DoesNotDependOnTheRateOfImages) {
  const auto varianceOf = [](int steps) {
    Pose step = Pose::Identity();
    step.translation().x() = 1.0 / steps;
    step.linear() = expSo3({0, 0, 0.5 / steps});
    return Vector6(steps * odometryNoise({}, step, 1.0 / steps).cwiseAbs2());
  };
  EXPECT_LT((varianceOf(5) - varianceOf(50)).norm(), 1e-12);
}

/// After a clock that jumped the robot is still in its building.
TEST(WalkNoise, ADayIsNoMoreThanTenSeconds) {
  EXPECT_EQ(walkNoise({}, 86400), walkNoise({}, 10));
  EXPECT_GT(walkNoise({}, 10)[0], walkNoise({}, 9)[0]);
}

TEST(OdometryNoise, VanishesWithoutTimeAndMotion) {
  EXPECT_EQ(odometryNoise({}, Pose::Identity(), 0), Vector6::Zero());
  EXPECT_GT(odometryNoise({}, Pose::Identity(), 0.1).minCoeff(), 0);
  EXPECT_GT(odometryNoise({}, kStep, 0).minCoeff(), 0);
}

TEST(WalkNoise, IsTheSumOfARandomWalkAndAnUnknownAcceleration) {
  FilterParameters p;
  p.walk_position_rate = 0.05;
  p.walk_angle_rate_deg = 4;
  p.walk_acceleration = 2;
  p.walk_angular_acceleration_deg = 50;
  // In 4 s a random walk doubles the noise of 1 s. The way of an acceleration a is a t^2 / 2 = 8 a.
  const Vector6 sigma = walkNoise(p, 4);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(sigma[i], 2 * 0.05 + 8 * 2, 1e-12);
  for (int i = 3; i < 6; ++i) EXPECT_NEAR(sigma[i], (2 * 4 + 8 * 50) * M_PI / 180, 1e-12);
  EXPECT_EQ(walkNoise(p, 0), Vector6::Zero());
}

TEST(Moved, TheMeanIsComposedAndTheNoiseIsAddedAfterTheStep) {
  const PoseGaussian after = moved({kPose, Matrix6::Zero()}, kStep, twist(1, 2, 3, 4, 5, 6));
  EXPECT_TRUE(after.mean.isApprox(kPose * kStep, 1e-12));
  const Matrix6 expected = twist(1, 4, 9, 16, 25, 36).asDiagonal();
  EXPECT_TRUE(after.covariance.isApprox(expected, 1e-12));
}

/// A base with an uncertain yaw of standard deviation s moves 10 m ahead. Then its lateral position
/// has the standard deviation 10 s, and it is fully correlated with the yaw.
TEST(Moved, AnUncertainYawBecomesALateralUncertainty) {
  constexpr double kYaw = 0.02;
  PoseGaussian pose{kPose, Matrix6::Zero()};
  pose.covariance(5, 5) = kYaw * kYaw;
  const Pose ahead(Eigen::Translation3d(10, 0, 0));
  Matrix6 expected = Matrix6::Zero();
  expected(5, 5) = kYaw * kYaw;
  expected(1, 5) = expected(5, 1) = 10 * kYaw * kYaw;
  expected(1, 1) = 100 * kYaw * kYaw;
  EXPECT_LT((moved(pose, ahead, Vector6::Zero()).covariance - expected).norm(), 1e-12);
}

/// After a quarter turn to the left, the old x axis points along the new -y axis.
TEST(Moved, TheCovarianceIsTurnedIntoTheNewAxes) {
  const PoseGaussian pose{kPose, twist(0.01, 0.04, 0.09, 0.16, 0.25, 0.36).asDiagonal()};
  Pose turn = Pose::Identity();
  turn.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Matrix6 expected = twist(0.04, 0.01, 0.09, 0.25, 0.16, 0.36).asDiagonal();
  EXPECT_LT((moved(pose, turn, Vector6::Zero()).covariance - expected).norm(), 1e-12);
}

/// The truth is a cloud of random poses that are moved one by one, each with its own noise.
TEST(Moved, AgreesWithPosesThatAreMovedOneByOne) {
  RandomSource random(21);
  const Twist before = twist(0.03, 0.02, 0.05, 0.02, 0.01, 0.03);
  const Twist sigma = twist(0.01, 0.02, 0.03, 0.005, 0.01, 0.015);
  constexpr int kPoses = 20000;
  std::vector<Pose> poses;
  poses.reserve(kPoses);
  for (int i = 0; i < kPoses; ++i)
    poses.push_back(kPose * expSe3(before.cwiseProduct(random.normalTwist())) * kStep *
                    expSe3(sigma.cwiseProduct(random.normalTwist())));
  const PoseGaussian cloud = meanAndCovariance(poses, std::vector<double>(kPoses, 1));
  const PoseGaussian after = moved({kPose, before.cwiseAbs2().asDiagonal()}, kStep, sigma);
  EXPECT_LT(logSe3(after.mean.inverse() * cloud.mean).norm(), 0.002);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      // The error of a sample covariance is 1/141 of the product of both standard deviations, or
      // sqrt(2) times this value on the diagonal. Four of these are allowed.
      const double scale = std::sqrt(after.covariance(i, i) * after.covariance(j, j));
      EXPECT_NEAR(cloud.covariance(i, j), after.covariance(i, j), 4 * 1.42 / 141 * scale)
          << i << " " << j;
    }
}

TEST(Moved, TheRotationStaysOrthonormalOverManySteps) {
  PoseGaussian pose;
  for (int i = 0; i < 10000; ++i) pose = moved(pose, kStep, Vector6::Zero());
  EXPECT_LT(
      (pose.mean.linear() * pose.mean.linear().transpose() - Eigen::Matrix3d::Identity()).norm(),
      1e-12);
}

}  // namespace
}  // namespace edge_mcl
