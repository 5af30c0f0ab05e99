#include "edge_mcl/core/base/se3.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

/// Rotations are limited to 3 rad, because the logarithm is unique below pi only.
TEST(Se3, LogIsTheInverseOfExp) {
  RandomSource random(1);
  for (int i = 0; i < 1000; ++i) {
    Twist xi = random.normalTwist();
    const double angle = xi.tail<3>().norm();
    if (angle > 3) xi.tail<3>() *= 3 / angle;
    EXPECT_LT((logSe3(expSe3(xi)) - xi).norm(), 1e-9);
  }
  EXPECT_LT((logSe3(expSe3(1e-9 * Twist::Ones())) - 1e-9 * Twist::Ones()).norm(), 1e-15);
}

TEST(Se3, ExpOfAScrewAgreesWithItsClosedForm) {
  // The twist is a quarter turn about z with a rise of 0.7 m. The point moves on a circle of radius
  // 1 in x and y, so its end is (1, 1, 0.7).
  Twist xi;
  xi << M_PI / 2, 0, 0.7, 0, 0, M_PI / 2;
  const Pose pose = expSe3(xi);
  EXPECT_NEAR(pose.translation().x(), 1, 1e-12);
  EXPECT_NEAR(pose.translation().y(), 1, 1e-12);
  EXPECT_NEAR(pose.translation().z(), 0.7, 1e-12);
}

/// The adjoint obeys its definition T exp(xi) = exp(Ad_T xi) T.
TEST(Se3, AdjointMovesATwistAcrossAPose) {
  RandomSource random(2);
  const Pose t = expSe3(random.normalTwist());
  const Twist xi = 0.1 * random.normalTwist();
  EXPECT_LT(((t * expSe3(xi)).matrix() - (expSe3(adjoint(t) * xi) * t).matrix()).norm(), 1e-12);
}

TEST(Se3, MeanAndCovarianceOfASymmetricSetHaveAClosedForm) {
  // The poses mean * exp(+-d_k) have equal weights and lie symmetrically. So their mean is exactly
  // `mean`. Their covariance is the mean of d d^T, including the signs of the cross terms.
  RandomSource random(3);
  const Pose mean = expSe3(random.normalTwist());
  std::vector<Pose> poses;
  Matrix6 covariance = Matrix6::Zero();
  for (int k = 0; k < 7; ++k) {
    const Twist d = 0.2 * random.normalTwist();
    poses.push_back(mean * expSe3(d));
    poses.push_back(mean * expSe3(-d));
    covariance += d * d.transpose() / 7;
  }
  const PoseGaussian g = meanAndCovariance(poses, std::vector<double>(poses.size(), 0.5));
  EXPECT_LT((g.mean.matrix() - mean.matrix()).norm(), 1e-9);
  EXPECT_LT((g.covariance - covariance).norm(), 1e-8);
}

/// A covariance that is converted to map axes and back does not change.
TEST(Se3, MapAxesCovarianceRoundTrip) {
  RandomSource random(4);
  PoseGaussian g;
  g.mean = expSe3(random.normalTwist());
  const Matrix6 a = Matrix6::Random();
  g.covariance = a * a.transpose();
  EXPECT_LT((covarianceFromMapAxes(g.mean, covarianceInMapAxes(g)) - g.covariance).norm(), 1e-12);
}

/// Rays that begin or end at such places end the process in a library.
TEST(Se3, AValidPoseIsOnEarth) {
  Pose pose = Pose::Identity();
  pose.translation() << 5e5, -5.4e6, 200;  // m, national coordinates
  EXPECT_TRUE(isValid(pose));
  for (const double far : {1.1e8, -1e39, std::nan(""), HUGE_VAL}) {
    pose.translation().y() = far;
    EXPECT_FALSE(isValid(pose)) << far;
  }
}

TEST(Se3, MeanOfNothingIsAnError) {
  EXPECT_THROW(meanAndCovariance({}, {}), Error);
  EXPECT_THROW(meanAndCovariance({Pose::Identity()}, {0.0}), Error);
}

}  // namespace
}  // namespace edge_mcl
