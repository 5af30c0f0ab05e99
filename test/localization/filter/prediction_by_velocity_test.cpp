// Tests predictions without odometry and without images.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/localization/filter/pose_filter.h"

namespace edge_mcl {
namespace {

/// A clock that jumps by fifty years moves no particle off the earth, where rays end the process.
TEST(PredictionByVelocity, AVeryLongStepMovesTheParticlesThroughTheBuildingOnly) {
  PoseFilter filter{FilterParameters(), RefinementParameters()};
  filter.initialize(Pose::Identity(), 0.1, 0.05);
  filter.predictWithoutOdometry(1.7e9);
  for (const Pose& pose : filter.poses()) EXPECT_LT(pose.translation().norm(), 500);
}

/// An IMU tells roll and pitch while nothing else does. The particles stay upright.
TEST(PredictionByVelocity, WithoutImagesAnImuKeepsTheParticlesUpright) {
  PoseFilter filter{FilterParameters(), RefinementParameters()};
  filter.initialize(Pose::Identity(), 0.05, 0.02);
  for (int i = 0; i < 30; ++i) {
    filter.predictWithoutOdometry(0.1);
    ASSERT_TRUE(filter.correctTilt({Eigen::Vector3d::UnitZ(), 0.02})) << "step " << i;
  }
  for (const Pose& pose : filter.poses())  // five standard deviations
    EXPECT_LT(std::acos(std::min(1.0, pose.linear()(2, 2))), 5 * 0.02 * std::sqrt(2));
  const Matrix6& covariance = filter.estimate().covariance;
  EXPECT_LT(std::sqrt(covariance(3, 3)), 0.03);
  EXPECT_LT(std::sqrt(covariance(4, 4)), 0.03);
  EXPECT_GT(std::sqrt(covariance(5, 5)), 0.3);  // the heading is free
}

}  // namespace
}  // namespace edge_mcl
