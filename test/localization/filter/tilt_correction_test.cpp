#include "edge_mcl/localization/filter/tilt_correction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "edge_mcl/localization/filter/mode_proposal.h"

namespace edge_mcl {
namespace {

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

/// The up direction in the axes of a base.
Eigen::Vector3d upOf(const Pose& T_map_base) { return T_map_base.linear().transpose() * kUp; }

/// Poses around a tilted one, with standard deviations in metres and radians.
std::vector<Pose> cloudAround(const Pose& mean, double position, double angle, int count,
                              uint64_t seed) {
  RandomSource random(seed);
  Twist sigma;
  sigma << Eigen::Vector3d::Constant(position), Eigen::Vector3d::Constant(angle);
  std::vector<Pose> poses;
  poses.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i)
    poses.push_back(mean * expSe3(sigma.cwiseProduct(random.normalTwist())));
  return poses;
}

const Pose kTilted = expSe3((Twist() << 1, 2, 3, 0.2, -0.3, 1.0).finished());

/// The header defines the result: R_map_base * exp(result) has the measured up direction, and the
/// result is perpendicular to it. The angle is the angle between both up directions.
TEST(TiltError, TurnsThePoseToTheReading) {
  RandomSource random(42);
  for (int i = 0; i < 200; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() = expSo3(3 * random.uniform() * random.direction());
    const Eigen::Vector3d reading = random.direction();
    const Eigen::Vector3d error = tiltError(pose, reading);
    EXPECT_LT((pose.linear() * expSo3(error) * reading - kUp).norm(), 1e-9);
    EXPECT_NEAR(error.dot(reading), 0, 1e-9);
    EXPECT_NEAR(std::cos(error.norm()), upOf(pose).dot(reading), 1e-9);
    EXPECT_LE(error.norm(), M_PI + 1e-9);
  }
}

TEST(TiltError, IsZeroWhereThePoseAgrees) {
  EXPECT_LT(tiltError(kTilted, upOf(kTilted)).norm(), 1e-12);
  EXPECT_EQ(tiltError(Pose::Identity(), kUp), Eigen::Vector3d::Zero());
}

TEST(TiltError, APoseUpsideDownIsTurnedByHalfATurn) {
  const Eigen::Vector3d error = tiltError(Pose::Identity(), -kUp);
  EXPECT_NEAR(error.norm(), M_PI, 1e-12);
  EXPECT_NEAR(error.z(), 0, 1e-12);
}

TEST(TiltCorrection, IsTheProductOfGaussians) {
  // Particles are drawn around a tilted pose, and the IMU gives one reading. For small angles the
  // posterior of each axis is known in closed form.
  RandomSource random(41);
  const Pose truth = expSe3((Twist() << 1, 2, 3, 0.2, -0.3, 1.0).finished());
  const double spread = 0.04, sigma = 0.02, offset = 0.05;
  const Eigen::Vector3d axis =
      (truth.linear().transpose() * Eigen::Vector3d::UnitZ()).unitOrthogonal();
  PoseGaussian prior{truth, spread * spread * Matrix6::Identity()};
  // The reading is turned by `offset` from the mean of the particles.
  Pose turned = truth;
  turned.linear() = truth.linear() * expSo3(offset * axis);
  const UpReading reading{turned.linear().transpose() * Eigen::Vector3d::UnitZ(), sigma};
  EXPECT_NEAR((tiltError(truth, reading.up_base) - offset * axis).norm(), 0, 1e-9);

  constexpr int kParticles = 20000;
  std::vector<Pose> poses;
  poses.reserve(kParticles);
  const GaussianDensity density(prior);
  for (int i = 0; i < kParticles; ++i) poses.push_back(density.draw(&random));
  const std::vector<double> weights(kParticles, 1.0);
  ASSERT_TRUE(correctTilt(reading, weights, &random, &poses));
  const PoseGaussian after = meanAndCovariance(poses, weights),
                     gaussian = correctTilt(reading, prior);
  const double gain = spread * spread / (spread * spread + sigma * sigma);
  const double left = spread * sigma / std::hypot(spread, sigma);  // standard deviation
  for (const PoseGaussian& p : {after, gaussian}) {
    const Eigen::Vector3d shift = logSo3(truth.linear().transpose() * p.mean.linear());
    // The mean of 20000 draws has an error of 1/141 of its spread. Curvature adds the square of the
    // offset.
    EXPECT_NEAR((shift - gain * offset * axis).norm(), 0, 0.0015);
    const Eigen::Matrix3d c = p.covariance.bottomRightCorner<3, 3>();
    EXPECT_NEAR(std::sqrt(axis.dot(c * axis)), left, 0.03 * left);
    const Eigen::Vector3d vertical = p.mean.linear().transpose() * Eigen::Vector3d::UnitZ();
    // The yaw does not change.
    EXPECT_NEAR(std::sqrt(vertical.dot(c * vertical)), spread, 0.03 * spread);
    EXPECT_NEAR(p.covariance(0, 0), spread * spread, 0.04 * spread * spread);
  }
  // A reading that no particle explains changes nothing.
  turned.linear() = truth.linear() * expSo3(1.0 * axis);
  const std::vector<Pose> before = poses;
  EXPECT_FALSE(correctTilt({turned.linear().transpose() * Eigen::Vector3d::UnitZ(), sigma}, weights,
                           &random, &poses));
  EXPECT_EQ(poses[7].matrix(), before[7].matrix());
}

/// Every pose turns about an axis that is perpendicular to the measured up direction. So it turns
/// about the vertical at most by the product of the turn and the pose's tilt against the reading.
TEST(TiltCorrection, PositionAndHeadingOfAParticleStay) {
  const std::vector<Pose> before = cloudAround(kTilted, 0.3, 0.05, 500, 43);
  std::vector<Pose> after = before;
  RandomSource random(44);
  const UpReading reading{upOf(kTilted), 0.01};
  ASSERT_TRUE(correctTilt(reading, std::vector<double>(500, 1), &random, &after));
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(after[i].translation(), before[i].translation());
    const Eigen::Vector3d turn = logSo3(before[i].linear().transpose() * after[i].linear());
    EXPECT_NEAR(turn.dot(reading.up_base), 0, 1e-9);
  }
}

TEST(TiltCorrection, OnlyTheRatiosOfTheWeightsCount) {
  const std::vector<Pose> before = cloudAround(kTilted, 0.1, 0.05, 100, 45);
  std::vector<double> weights(100), thousandfold(100);
  for (size_t i = 0; i < 100; ++i) {
    weights[i] = i % 4 == 0 ? 0.03 : 0.002;
    thousandfold[i] = 1000 * weights[i];
  }
  std::vector<Pose> a = before, b = before;
  RandomSource first(46), second(46);
  ASSERT_TRUE(correctTilt({upOf(kTilted), 0.02}, weights, &first, &a));
  ASSERT_TRUE(correctTilt({upOf(kTilted), 0.02}, thousandfold, &second, &b));
  // The two sums of weights are rounded differently.
  for (size_t i = 0; i < 100; ++i) EXPECT_TRUE(a[i].isApprox(b[i], 1e-12));
}

/// Half of the particles are tilted by 0.3 rad but have no weight. The reading agrees with them and
/// contradicts the others, so it contradicts the cloud.
TEST(TiltCorrection, ParticlesWithoutWeightDoNotDecide) {
  std::vector<Pose> poses = cloudAround(kTilted, 0.1, 0.02, 100, 47);
  std::vector<double> weights(100, 1);
  const Eigen::Vector3d axis = upOf(kTilted).unitOrthogonal();
  for (size_t i = 0; i < 100; i += 2) {
    poses[i].linear() = poses[i].linear() * expSo3(0.3 * axis);
    weights[i] = 0;
  }
  Pose turned = kTilted;
  turned.linear() = kTilted.linear() * expSo3(0.3 * axis);
  RandomSource random(48);
  // 0.3 rad are more than ten standard deviations of particles and reading together.
  EXPECT_FALSE(correctTilt({upOf(turned), 0.02}, weights, &random, &poses));
  weights.assign(100, 1);
  EXPECT_TRUE(correctTilt({upOf(turned), 0.02}, weights, &random, &poses));
}

/// The reading may have any length, only its direction counts.
TEST(TiltCorrection, ALongReadingCountsAsItsDirection) {
  const PoseGaussian prior{kTilted, 0.01 * Matrix6::Identity()};
  const PoseGaussian unit = correctTilt({kUp, 0.02}, prior);
  const PoseGaussian gravity = correctTilt({9.81 * kUp, 0.02}, prior);
  EXPECT_TRUE(gravity.mean.isApprox(unit.mean, 1e-12));
  EXPECT_TRUE(gravity.covariance.isApprox(unit.covariance, 1e-12));
}

/// A level base has the roll variance v and the covariance c of roll and x. A reading of roll with
/// the error e and the variance s moves x by e c / (v + s) and lowers its variance by c^2 / (v +
/// s). This is the Kalman update of two scalars.
TEST(TiltCorrection, WhatIsCorrelatedWithTheTiltMovesWithIt) {
  constexpr double kVariance = 0.0016, kCorrelated = 0.002, kSigma = 0.02, kError = 0.001;
  PoseGaussian prior{Pose::Identity(), kVariance * Matrix6::Identity()};
  prior.covariance(0, 0) = 0.01;
  prior.covariance(0, 3) = prior.covariance(3, 0) = kCorrelated;
  const Eigen::Vector3d up = expSo3(Eigen::Vector3d(kError, 0, 0)).transpose() * kUp;
  const PoseGaussian after = correctTilt({up, kSigma}, prior);
  const double innovation = kVariance + kSigma * kSigma;
  // The up direction is turned by 0.001 rad, which changes the axes of the covariance by as much.
  EXPECT_NEAR(logSo3(after.mean.linear()).x(), kError * kVariance / innovation, 1e-6);
  EXPECT_NEAR(after.mean.translation().x(), kError * kCorrelated / innovation, 1e-5);
  EXPECT_NEAR(after.covariance(0, 0), 0.01 - kCorrelated * kCorrelated / innovation, 1e-5);
  EXPECT_NEAR(after.covariance(3, 3), kVariance * kSigma * kSigma / innovation, 1e-6);
  EXPECT_NEAR(after.covariance(5, 5), kVariance, 1e-6);  // the yaw
}

}  // namespace
}  // namespace edge_mcl
