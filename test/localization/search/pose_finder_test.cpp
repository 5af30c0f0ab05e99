#include "edge_mcl/localization/search/pose_finder.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

const Pose kStep = expSe3((Twist() << 0.1, 0.02, -0.03, 0.01, -0.02, 0.1).finished());
const Pose kTurn = expSe3((Twist() << 0, 0, 0, 0, 0, 0.5).finished());

/// A motion along x and about z. @param blind seconds without odometry
BaseMotion motionOf(double metres, double degrees, double elapsed, double blind = 0) {
  BaseMotion motion;
  motion.step.translation().x() = metres;
  motion.step.linear() = expSo3(Eigen::Vector3d(0, 0, degrees * kDegree));
  motion.elapsed = elapsed;
  motion.blind = blind;
  return motion;
}

TEST(BaseMotion, OfOdometryHasTheNoiseOfOdometry) {
  const BaseMotion motion = BaseMotion::of({}, kStep, 0.2);
  EXPECT_EQ(motion.step.matrix(), kStep.matrix());
  EXPECT_EQ(motion.variance, odometryNoise({}, kStep, 0.2).cwiseAbs2());
  EXPECT_EQ(motion.elapsed, 0.2);
  EXPECT_EQ(motion.blind, 0);
}

TEST(BaseMotion, WithoutOdometryTheBaseStandsStillWithTheNoiseOfAWalk) {
  const BaseMotion motion = BaseMotion::of({}, std::nullopt, 0.2);
  EXPECT_EQ(motion.step.matrix(), Pose::Identity().matrix());
  EXPECT_EQ(motion.variance, walkNoise({}, 0.2).cwiseAbs2());
  EXPECT_EQ(motion.elapsed, 0.2);
  EXPECT_EQ(motion.blind, 0.2);
}

/// Steps are composed in their order. Variances and times are added.
TEST(BaseMotion, ALaterMotionIsAppended) {
  BaseMotion both = BaseMotion::of({}, kStep, 0.2);
  const BaseMotion later = BaseMotion::of({}, kTurn, 0.3);
  const Vector6 variance = both.variance + later.variance;
  both.add(later);
  both.add(BaseMotion::of({}, std::nullopt, 0.5));
  EXPECT_TRUE(both.step.isApprox(kStep * kTurn, 1e-12));
  EXPECT_FALSE(both.step.isApprox(kTurn * kStep, 1e-3));
  EXPECT_TRUE(both.variance.isApprox(variance + walkNoise({}, 0.5).cwiseAbs2(), 1e-12));
  EXPECT_NEAR(both.elapsed, 1, 1e-12);
  EXPECT_NEAR(both.blind, 0.5, 1e-12);
}

TEST(BaseMotion, NothingIsAddedByNoMotion) {
  BaseMotion motion = BaseMotion::of({}, kStep, 0.2);
  motion.add({});
  EXPECT_TRUE(motion.step.isApprox(kStep, 1e-12));
  EXPECT_EQ(motion.elapsed, 0.2);
}

/// The limits are chosen as 0.2 m, 10 degrees and 0.5 s.
class KeyframeRule : public testing::Test {
 protected:
  KeyframeRule() {
    params_.keyframe_distance = 0.2;
    params_.keyframe_angle_deg = 10;
    params_.keyframe_period = 0.5;
  }
  SearchParameters params_;
};

TEST_F(KeyframeRule, EnoughDistanceOrEnoughRotationMakesANewView) {
  EXPECT_TRUE(motionOf(0.21, 0, 0.1).isKeyframe(params_));
  EXPECT_TRUE(motionOf(-0.21, 0, 0.1).isKeyframe(params_));
  EXPECT_TRUE(motionOf(0, 10.1, 0.1).isKeyframe(params_));
  EXPECT_TRUE(motionOf(0, -10.1, 0.1).isKeyframe(params_));
  EXPECT_FALSE(motionOf(0.19, 9.9, 0.1).isKeyframe(params_));
}

TEST_F(KeyframeRule, WithOdometryTheTimeDoesNotCount) {
  EXPECT_FALSE(motionOf(0, 0, 100).isKeyframe(params_));
}

TEST_F(KeyframeRule, WithoutOdometryOnlyTheTimeCounts) {
  EXPECT_FALSE(motionOf(1, 90, 0.4, 0.1).isKeyframe(params_));
  EXPECT_TRUE(motionOf(0, 0, 0.5, 0.1).isKeyframe(params_));
  EXPECT_TRUE(motionOf(0, 0, 0.6, 0.6).isKeyframe(params_));
}

}  // namespace
}  // namespace edge_mcl
