#include "edge_mcl/localization/filter/recovery_averages.h"

#include <gtest/gtest.h>

#include <cmath>

namespace edge_mcl {
namespace {

/// The truth is the closed form of exponential averages.
TEST(RecoveryAverages, InjectAsTheFastOneFallsBelowTheSlowOne) {
  FilterParameters params;
  params.recovery_alpha_slow = 0.1;
  params.recovery_alpha_fast = 0.5;
  RecoveryAverages averages;
  EXPECT_EQ(averages.shareToInject(), 0);
  for (int i = 0; i < 50; ++i) averages.add(10, params);
  EXPECT_EQ(averages.shareToInject(), 0);
  // After n images of value 2, an average with weight a is 2 + 8 (1 - a)^n.
  for (int n = 1; n <= 5; ++n) {
    averages.add(2, params);
    const double expected = 1 - (2 + 8 * std::pow(0.5, n)) / (2 + 8 * std::pow(0.9, n));
    EXPECT_NEAR(averages.shareToInject(), expected, 1e-12);
  }
  // Images that fit better than usual inject no particles. Images with a negative figure count as
  // zero.
  for (int i = 0; i < 9; ++i) averages.add(100, params);
  EXPECT_EQ(averages.shareToInject(), 0);
  for (int i = 0; i < 200; ++i) averages.add(-5, params);
  EXPECT_GE(averages.shareToInject(), 0);
  EXPECT_LE(averages.shareToInject(), 1);
}

TEST(RecoveryAverages, AreOffByDefault) {
  RecoveryAverages averages;
  for (const double fit : {10.0, 10.0, 0.0, 0.0, 0.0}) averages.add(fit, FilterParameters());
  EXPECT_EQ(averages.shareToInject(), 0);
}

}  // namespace
}  // namespace edge_mcl
