#include "edge_mcl/localization/search/jump_cost.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/angles.h"

namespace edge_mcl {
namespace {

/// 10 cm and 2 degrees in every axis.
PoseGaussian expectation() {
  PoseGaussian expected;
  expected.mean = expSe3((Twist() << 1, 2, 3, 0.4, 0.5, 0.6).finished());
  const double position = 0.1, angle = 2 * kDegree;
  expected.covariance.setZero();
  expected.covariance.diagonal() << Eigen::Vector3d::Constant(position * position),
      Eigen::Vector3d::Constant(angle * angle);
  return expected;
}

double costOf(double metres) {
  const PoseGaussian expected = expectation();
  Twist away = Twist::Zero();
  away[1] = metres;
  return jumpCost(expected, expected.mean * expSe3(away));
}

TEST(JumpCost, OfTheExpectedPoseIsZero) { EXPECT_NEAR(costOf(0), 0, 1e-12); }

/// Closed form of Student's t: (4 + 6) / 2 ln(1 + d^2 / 4).
TEST(JumpCost, IsThatOfStudentsT) {
  EXPECT_NEAR(costOf(0.1), 5 * std::log(1.25), 1e-9);
  EXPECT_NEAR(costOf(0.5), 5 * std::log(1 + 25 / 4.0), 1e-9);
}

/// A hypothesis that leaps 2 m to a better fit pays for it, but less than a Gaussian would ask
/// (200 nats): the odometry may be wrong.
TEST(JumpCost, GrowsSlowlyFarAway) {
  EXPECT_GT(costOf(2), 20);
  EXPECT_LT(costOf(2), 40);
}

}  // namespace
}  // namespace edge_mcl
