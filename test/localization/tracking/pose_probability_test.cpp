#include "edge_mcl/localization/tracking/pose_probability.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

UpdateReport edges(double contrast, double lines) {
  UpdateReport report;
  report.has_information = true;
  report.contrast = contrast;
  report.visible_lines = lines;
  return report;
}

TEST(LogOdds, GrowWithContrast) {
  EXPECT_LT(oddsOf(edges(4, 30))->log_odds, oddsOf(edges(8, 30))->log_odds);
}

/// A pose that fits by chance has a contrast of about 4, a right one 7 or more.
TEST(LogOdds, OfAChanceFitSpeakAgainstThePose) {
  EXPECT_LT(oddsOf(edges(4, 60))->log_odds, -2);
  EXPECT_GT(oddsOf(edges(10, 60))->log_odds, 2);
}

TEST(LogOdds, AreFiniteForAnyContrast) {
  for (const double contrast : {-100.0, 0.0, 1e9})
    for (const double lines : {0.01, 1e6})
      EXPECT_LE(std::abs(oddsOf(edges(contrast, lines))->log_odds), 8);
}

TEST(LogOdds, WithoutInformationThereAreNone) { EXPECT_FALSE(oddsOf(UpdateReport())); }

TEST(LogOdds, OfDepthFollowTheAgreement) {
  UpdateReport report;
  report.has_information = true;
  report.depth_points = 500;
  report.depth_agreement = 0.9;
  EXPECT_GT(oddsOf(report)->log_odds, 3);
  report.depth_agreement = 0.1;
  EXPECT_LT(oddsOf(report)->log_odds, 0);
}

/// Of poses tracked from wrong starts (docs/decisions/tracking-probability.md) with ten lines in
/// view or more, one in a hundred has 95 % of the depth on the model. With fewer than six lines it
/// is one in twenty: a single wall fits many poses.
TEST(LogOdds, DepthThatLiesOnTheModelSpeaksForThePose) {
  EXPECT_GT(oddsOf(edges(6, 12), 0.98)->log_odds, oddsOf(edges(6, 12))->log_odds + 3);
  EXPECT_NEAR(oddsOf(edges(8, 10), 0.5)->log_odds, oddsOf(edges(8, 10))->log_odds - 2, 1e-9);
  EXPECT_LT(oddsOf(edges(4.5, 2), 0.98)->log_odds, -2);
  // An inexact model does not rule out a pose with a good contrast.
  EXPECT_GT(oddsOf(edges(10, 20), 0)->log_odds, 1);
  EXPECT_EQ(oddsOf(edges(10, 40), 0)->log_odds, oddsOf(edges(10, 40))->log_odds);
  for (const double contrast : {-1.0, 1e9})
    EXPECT_LE(std::abs(oddsOf(edges(contrast, 9), 0.9)->log_odds), 8);
}

/// All data that were used must agree with the pose.
TEST(LogOdds, OfBothCuesAreTheLowerOnes) {
  UpdateReport report = edges(12, 60);
  report.depth_points = 500;
  report.depth_agreement = 0.1;
  EXPECT_LT(oddsOf(report)->log_odds, 0);
}

/// Where motion tells two look-alikes apart and the image does not, trust is neither built nor
/// lost.
TEST(PoseProbability, AmongLookAlikesThatOnlyMotionTellsApartItStays) {
  for (const bool is_trusted : {false, true}) {
    PoseProbability p;
    p.begin(false);
    for (int k = 0; is_trusted && k < 40; ++k) p.add(0.1 * k, {6, 1});
    const double before = p.value();
    for (int k = 40; k < 60; ++k) p.add(0.1 * k, amongLookAlikes({6, 1}, -0.5, 3));
    EXPECT_NEAR(p.value(), before, 0.03) << is_trusted;
    // An image that tells them apart wins.
    for (int k = 60; k < 70; ++k) p.add(0.1 * k, amongLookAlikes({6, 1}, -6, 3));
    EXPECT_LT(p.value(), 0.15);
  }
  EXPECT_EQ(amongLookAlikes({6, 1}, 8, 0).log_odds, 6);
  EXPECT_EQ(amongLookAlikes({6, 1}, 2, 3).log_odds, 2);
}

TEST(PoseProbability, OneImageDoesNotProveAPose) {
  PoseProbability p;
  p.begin(false);
  p.add(0, {2.0, 1});
  EXPECT_LT(p.value(), 0.8);
  for (int k = 1; k < 20; ++k) p.add(0.1 * k, {2.0, 1});
  EXPECT_GT(p.value(), 0.9);
}

/// After some seconds the rate of images makes no difference. A fast camera gets there earlier.
TEST(PoseProbability, SettlesAtTheSameValueAtAnyRate) {
  PoseProbability slow, fast;
  slow.begin(false);
  fast.begin(false);
  for (int k = 0; k <= 30; ++k) slow.add(0.1 * k, {3.0, 1});
  for (int k = 0; k <= 180; ++k) fast.add(k / 60.0, {3.0, 1});
  EXPECT_NEAR(slow.value(), fast.value(), 0.02);
}

/// A bare wall says little: it neither proves a pose nor takes the trust in it away.
TEST(PoseProbability, ImagesWithFewLinesSayLittle) {
  EXPECT_LT(oddsOf(edges(5, 2))->weight, 0.3);
  EXPECT_EQ(oddsOf(edges(5, 40))->weight, 1);
  PoseProbability p;
  p.begin(false);
  p.add(0, {4, 0.2});
  EXPECT_LT(p.value(), 0.8);
  for (int k = 1; k < 30; ++k) p.add(0.1 * k, {6, 1});
  for (int k = 30; k < 33; ++k) p.add(0.1 * k, {-3, 0.2});
  EXPECT_GT(p.value(), 0.8);
}

TEST(PoseProbability, APoseThatTheSearchHasProvenIsTrusted) {
  PoseProbability p;
  p.begin(true);
  EXPECT_GT(p.value(), 0.9);
}

TEST(PoseProbability, OneImageCanCastDoubt) {
  PoseProbability p;
  p.begin(false);
  for (int k = 0; k < 30; ++k) p.add(0.1 * k, {6.0, 1});
  EXPECT_GT(p.value(), 0.99);
  p.add(3, {-6.0, 1});
  EXPECT_LT(p.value(), 0.05);
  p.add(3.1, {6.0, 1});
  EXPECT_GT(p.value(), 0.9);
}

/// A few doubtful images do not take away what the seconds before have proven. A second of images
/// that contradict does: the robot may have been carried away.
TEST(PoseProbability, WhatWasProvenOutlastsAFewDoubtfulImages) {
  PoseProbability p;
  p.begin(false);
  for (int k = 0; k < 60; ++k) p.add(0.1 * k, {4, 1});
  for (int k = 60; k < 65; ++k) p.add(0.1 * k, {-0.7, 1});
  EXPECT_GT(p.value(), 0.5);  // tracking.keep_probability
  for (int k = 65; k < 75; ++k) p.add(0.1 * k, {-4, 1});
  p.add(7.5, {4, 1});
  EXPECT_LT(p.value(), 0.2);
}

/// The state after many images, against the stationary point of the two-state model:
/// the weight of the images of a step balances what the change of state forgets.
TEST(PoseProbability, CertaintyIsLimitedByTheRateOfChange) {
  PoseProbability p;
  p.begin(false);
  for (int k = 0; k < 4000; ++k) p.add(0.1 * k, {6, 1});
  // Per step: log-odds + 0.1 / 2 * 6; the change of state (0.01 / s) takes about 0.001 * odds.
  const double odds = (std::exp(0.3) - 1) / 0.001;
  EXPECT_NEAR(std::log(p.value() / (1 - p.value())), std::log(odds), 0.25);
}

/// The first image after a gap shows something new, so it has its full weight: that of the time
/// since the last image, not since the last moment without one.
TEST(PoseProbability, TheFirstImageAfterAGapCountsInFull) {
  PoseProbability p;
  p.begin(false);
  p.add(0, {0, 1});
  for (int k = 1; k < 50; ++k) p.wait(0.1 * k);
  p.add(5, {2, 1});
  // Odds of 1 before, two seconds and more since the last image: log-odds of 2.
  EXPECT_NEAR(std::log(p.value() / (1 - p.value())), 2, 0.05);
}

TEST(PoseProbability, WithoutImagesItIsForgotten) {
  PoseProbability p;
  p.begin(false);
  for (int k = 0; k < 30; ++k) p.add(0.1 * k, {6.0, 1});
  p.wait(3);
  const double before = p.value();
  p.wait(6);
  p.wait(20);
  EXPECT_LT(p.value(), before);
  EXPECT_NEAR(p.value(), 0.5, 0.05);
}

}  // namespace
}  // namespace edge_mcl
