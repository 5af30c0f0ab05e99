#include "edge_mcl/localization/tracking/pose_proof.h"
#include "edge_mcl/localization/filter/motion_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace edge_mcl {
namespace {

/// A pose that is tracked at ten images per second. The expected times follow from the constants of
/// pose_proof.cpp.
class Followed : public testing::Test {
 protected:
  PoseGaussian at(double x) const {
    PoseGaussian pose;
    pose.mean.translation().x() = x;
    pose.covariance = Matrix6::Identity() * 1e-4;
    return pose;
  }
  /// Adds an image 0.1 s later. By odometry the robot stands still. @return whether the pose is
  /// trusted
  bool image(double x, bool confirmed = true, double lines = 20, double ratio = 0.9) {
    proof_.move(Pose::Identity(), odometryNoise(Parameters().filter, Pose::Identity(), 0.1));
    time_ += 0.1;
    return proof_.add({time_, true, confirmed, ratio, lines}, at(x));
  }
  /// Adds images until the pose is trusted, at most 100. @return their number
  int imagesUntilTrusted(double x, double lines = 20, double ratio = 0.9) {
    int count = 1;
    while (!image(x, true, lines, ratio) && count < 100) ++count;
    return count;
  }

  PoseProof proof_{Parameters()};
  double time_ = 0;
};

TEST_F(Followed, EveryImageThatFitsIsEnough) {
  proof_.begin(false);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(image(0.002 * i));  // the pose moves at 2 cm/s
  EXPECT_FALSE(image(0.04, false));
  EXPECT_TRUE(image(0.04));
}

TEST_F(Followed, ABadStartTakesASecond) {
  proof_.begin(true);
  // Ten intervals of 0.1 s have eleven images. One more or less is rounding.
  EXPECT_NEAR(imagesUntilTrusted(0), 11, 1);
  EXPECT_TRUE(image(0));
}

TEST_F(Followed, WhatFittedBeforeAGapDoesNotCount) {
  proof_.begin(true);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(image(0));
  proof_.interrupt(false);
  time_ += 10;
  EXPECT_NEAR(imagesUntilTrusted(0), 11, 1);
}

/// Images without lines have a match ratio of 1. They must not raise the usual match ratio of
/// lines.
TEST_F(Followed, ImagesJudgedByDepthAloneMakeLinesNoLessUsual) {
  proof_.begin(false);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(image(0, true, 4, 0.7));
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(image(0, true, 0, 1));
  EXPECT_TRUE(image(0, true, 4, 0.7));
}

/// After two images that do not fit, one image that fits is not enough.
TEST_F(Followed, AfterTwoDoubtsOneImageIsChance) {
  proof_.begin(false);
  EXPECT_TRUE(image(0));
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(image(0, false));
  EXPECT_NEAR(imagesUntilTrusted(0), 11, 1);
}

/// A proof needs 6 lines, or 15 lines when the robot may be anywhere.
TEST_F(Followed, WhereItMayBeAnywhereFewLinesProveLittle) {
  proof_.begin(false);
  proof_.require(true);
  EXPECT_NEAR(imagesUntilTrusted(0, 20), 11, 1);
  proof_.begin(false);
  proof_.require(false);
  EXPECT_NEAR(imagesUntilTrusted(0, 6), 11, 1);
  proof_.begin(false);
  proof_.require(true);
  EXPECT_NEAR(imagesUntilTrusted(0, 6), 63, 2);  // (15 / 6)^2 times as long
  // Once proven, the pose is about known. So 6 lines are enough again.
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(image(0, false));
  EXPECT_NEAR(imagesUntilTrusted(0, 6), 11, 1);
}

TEST_F(Followed, APoseWhereOdometryDidNotGoTakesASecond) {
  proof_.begin(false);
  EXPECT_TRUE(image(0));
  EXPECT_FALSE(image(0, false));
  // One image contradicts the pose. The next image fits, but 1 m away.
  EXPECT_NEAR(imagesUntilTrusted(1), 11, 1);
  EXPECT_TRUE(image(1));
  // This also holds without a contradicting image in between.
  EXPECT_NEAR(imagesUntilTrusted(3), 11, 1);
}

TEST_F(Followed, AfterADoubtLessIsSuspect) {
  // 0.2 m are 4 standard deviations of 5 cm. The squared distance of 16 lies between the two limits
  // of chi-square: the limit after a doubt and the usual limit.
  proof_.begin(false);
  EXPECT_TRUE(image(0));
  EXPECT_TRUE(image(0.2));
  EXPECT_FALSE(image(0.2, false));
  EXPECT_FALSE(image(0));
}

TEST_F(Followed, APoseThatSlidesAgainstOdometryIsNotTrustedForLong) {
  // The pose moves by 8 cm per image, and each image leaves an uncertainty of 20 cm. So each step
  // alone is likely.
  proof_.begin(false);
  PoseGaussian pose = at(0);
  EXPECT_TRUE(image(0));
  int trusted = 0;
  for (int i = 1; i <= 20; ++i) {
    proof_.move(Pose::Identity(), odometryNoise(Parameters().filter, Pose::Identity(), 0.1));
    time_ += 0.1;
    pose.mean.translation().x() = 0.08 * i;
    pose.covariance(0, 0) = 0.04;
    trusted += proof_.add({time_, true, true, 0.9, 20}, pose) ? 1 : 0;
  }
  // The first pose has a standard deviation of 1 cm, the tolerance is 5 cm, and odometry adds 1 cm
  // per image. So the limit of 40 of chi-square is exceeded at 0.35 m, by the fifth step.
  EXPECT_GE(trusted, 1);
  EXPECT_LE(trusted, 5);
}

/// The match ratio falls from 0.95 to 0.6. With 4 lines the pose needs proof again.
TEST_F(Followed, WhenSuddenlyLessIsSeenOfFewLinesItTakesLonger) {
  proof_.begin(false);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(image(0, true, 4, 0.95));
  EXPECT_TRUE(image(0, true, 4, 0.85));
  EXPECT_FALSE(image(0, true, 4, 0.6));
  // With many lines a lower match ratio is no surprise.
  proof_.begin(false);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(image(0, true, 20, 0.95));
  EXPECT_TRUE(image(0, true, 20, 0.6));
}

TEST_F(Followed, ItMayMoveAsOdometrySays) {
  proof_.begin(false);
  EXPECT_TRUE(image(0));
  Pose step = Pose::Identity();
  step.translation().x() = 1;
  proof_.move(step, odometryNoise(Parameters().filter, step, 0.1));
  EXPECT_TRUE(image(1));
}

/// A velocity that is off by 0.5 m/s moves the expected pose by 0.5 m in a second. With a known
/// velocity such a pose is elsewhere.
TEST_F(Followed, AnErrorOfTheVelocityIsNoOtherPlace) {
  const Vector6 noise = Vector6::Constant(0.005);
  const auto isTrustedAtTheEnd = [&](double velocity_sigma) {
    PoseProof proof{Parameters()};
    proof.begin(false);
    Pose step = Pose::Identity();
    step.translation().x() = 0.05;  // m in 0.1 s, but the robot stands still
    bool trusted = true;
    for (int i = 0; i < 12; ++i) {
      proof.moveByVelocity(step, noise, Vector6::Constant(0.1 * velocity_sigma));
      trusted = proof.add({0.1 * i, true, true, 0.9, 20}, at(0)) && trusted;
    }
    return trusted;
  };
  EXPECT_TRUE(isTrustedAtTheEnd(0.5));
  EXPECT_FALSE(isTrustedAtTheEnd(0.05));
}

/// Three lines and a surface are as good as six lines, but not where any bare wall would fit.
TEST_F(Followed, ASurfaceThatFitsCountsAsThreeLines) {
  const auto imagesUntilTrusted = [](bool anywhere) {
    PoseProof proof{Parameters()};
    proof.begin(true);
    if (anywhere) proof.require(true);
    PoseGaussian pose;
    pose.covariance = Matrix6::Identity() * 1e-4;
    int count = 1;
    while (!proof.add({0.1 * count, true, true, 0.9, 3, true}, pose) && count < 300) ++count;
    return count;
  };
  EXPECT_NEAR(imagesUntilTrusted(false), 11, 1);
  EXPECT_NEAR(imagesUntilTrusted(true), 251, 3);  // (15 / 3)^2 s
}

/// After 10 s in the dark the robot may be anywhere within some metres. But the images of one proof
/// must agree with each other.
TEST_F(Followed, ImagesThatFitInTwoPlacesProveNeither) {
  proof_.begin(false);
  EXPECT_TRUE(image(0));
  const Vector6 noise = Vector6::Constant(0.005), drift = Vector6::Constant(0.05);
  for (int i = 0; i < 100; ++i) proof_.moveByVelocity(Pose::Identity(), noise, drift);
  time_ += 10;
  proof_.interrupt(false);
  for (int i = 0; i < 30; ++i) EXPECT_FALSE(image(i % 2)) << i;
}

TEST_F(Followed, ItTakesLongerWithFewLinesAndWhereLessOfThemIsSeen) {
  proof_.begin(true);
  // With 2 instead of 6 lines the proof takes three times as long.
  EXPECT_NEAR(imagesUntilTrusted(0, 2), 31, 1);
  proof_.begin(true);
  // A match ratio of 0.4 is half of the required 0.8. The proof takes four times as long.
  EXPECT_NEAR(imagesUntilTrusted(0, 20, 0.4), 41, 1);
}

}  // namespace
}  // namespace edge_mcl
