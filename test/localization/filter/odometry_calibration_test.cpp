#include "edge_mcl/localization/filter/odometry_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

constexpr double kStep = 0.1;                                  // s
constexpr double kNoise = 0.005, kTurnNoise = 0.2 * kDegree;   // of a step, m and rad
constexpr double kImage = 0.002, kImageTurn = 0.02 * kDegree;  // of an estimate

Vector6 sigmas(double position, double angle) {
  Vector6 s;
  s << Eigen::Vector3d::Constant(position), Eigen::Vector3d::Constant(angle);
  return s;
}

/// A flight with odometry whose distances are short, which misses a turn, and is noisier than told.
OdometryCalibration flown(double scale_error, double turn_rate, double noise_factor, uint64_t seed,
                          double* remaining = nullptr) {
  RandomSource random(seed);
  OdometryCalibration odometry;
  const Vector6 told = sigmas(kNoise, kTurnNoise), image = sigmas(kImage, kImageTurn);
  double error = 0;
  constexpr int kSteps = 300, kHalf = 150;
  for (int k = 0; k < kSteps; ++k) {
    Pose truth = Pose::Identity();
    truth.translation() = Eigen::Vector3d(0.1, 0.02 * std::sin(0.1 * k), 0.01);
    truth.linear() = expSo3({0, 0, 0.05 * std::sin(0.05 * k)});
    Pose reported = truth;
    reported.linear() = truth.linear() * expSo3({0, 0, -turn_rate * kStep});
    reported.translation() /= 1 + scale_error;
    reported = reported * expSe3(noise_factor * told.cwiseProduct(random.normalTwist()));
    const Pose predicted = odometry.corrected(reported, kStep);
    const Twist innovation =
        logSe3(predicted.inverse() * truth) + image.cwiseProduct(random.normalTwist());
    if (k >= kHalf) error += logSe3(predicted.inverse() * truth).norm() / kHalf;
    odometry.learn(reported, kStep, innovation, told.cwiseAbs2(), image.cwiseAbs2().asDiagonal());
  }
  if (remaining) *remaining = error;
  return odometry;
}

TEST(OdometryCalibration, LeavesGoodOdometryAlone) {
  const OdometryCalibration odometry = flown(0, 0, 1, 1);
  EXPECT_NEAR(odometry.scaleError(), 0, 0.02);
  EXPECT_NEAR(odometry.turnRate().norm(), 0, 0.3 * kDegree);
  EXPECT_LT(odometry.noiseFactor(), 1.3);
}

/// 10 % and 3 degrees a second. The error of 150 steps of 10 cm with 5 mm of noise is 0.4 %.
TEST(OdometryCalibration, LearnsScaleAndTurn) {
  double learnt = 0, plain = 0;
  const OdometryCalibration odometry = flown(-0.1, 3 * kDegree, 1, 2, &learnt);
  EXPECT_NEAR(odometry.scaleError(), -0.1, 0.02);
  EXPECT_NEAR(odometry.turnRate().z(), 3 * kDegree, 0.4 * kDegree);
  flown(0, 0, 1, 2, &plain);
  EXPECT_LT(learnt, 1.2 * plain);
}

/// Noise must not look like a scale: this is where a regression on reported distances fails.
TEST(OdometryCalibration, NoiseIsNoScale) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const OdometryCalibration odometry = flown(0, 0, 5, seed);
    EXPECT_NEAR(odometry.scaleError(), 0, 0.07) << seed;
  }
}

TEST(OdometryCalibration, LearnsTheNoise) {
  double mean = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) mean += flown(0, 0, 3, seed).noiseFactor() / 10;
  EXPECT_NEAR(mean, 3, 0.6);
}

TEST(OdometryCalibration, StaysWithinItsLimits) {
  const OdometryCalibration odometry = flown(2, 1, 40, 3);
  EXPECT_LE(std::abs(odometry.scaleError()), 0.3);
  EXPECT_LE(odometry.turnRate().norm(), 15 * kDegree + 1e-12);
  EXPECT_LE(odometry.noiseFactor(), 5 + 1e-12);
}

TEST(OdometryCalibration, IgnoresWhatIsNotFinite) {
  OdometryCalibration odometry;
  Twist bad = Twist::Zero();
  bad[2] = std::numeric_limits<double>::quiet_NaN();
  odometry.learn(Pose::Identity(), kStep, bad, sigmas(kNoise, kTurnNoise), Matrix6::Identity());
  odometry.learn(Pose::Identity(), 0, Twist::Zero(), sigmas(kNoise, kTurnNoise),
                 Matrix6::Identity());
  EXPECT_EQ(odometry.scaleError(), 0);
  EXPECT_EQ(odometry.noiseFactor(), 1);
}

}  // namespace
}  // namespace edge_mcl
