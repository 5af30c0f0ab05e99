#include <gtest/gtest.h>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/pose_filter.h"
#include "edge_mcl/localization/filter/recovery_averages.h"
#include "support/scenes.h"

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

/// The camera moves farther than its odometry says, as if it was pushed. @param share largest share
/// of injected particles @return for how many of 20 seeds the filter finds the camera again, within
/// 5 cm
int recovered(const LocalizationMap& map, const FilterParameters& usual, double* share) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  const Pose before = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});
  const Pose after = before * expSe3((Twist() << 0.35, -0.1, 0.25, 0.05, 0.2, -0.04).finished());
  const auto viewFrom = [&](const Pose& pose) {
    const cv::Mat image = test::render(test::furnishedRooms(), camera, pose, 1);
    return CameraView{map.prepare(camera, image, {}, "test"), Pose::Identity(), 1, nullptr};
  };
  const CameraView first = viewFrom(before), second = viewFrom(after);
  int count = 0;
  *share = 0;
  constexpr int kSeeds = 20;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    FilterParameters params = usual;
    params.seed = static_cast<uint64_t>(seed);
    params.particles = 300;
    PoseFilter filter(params, map.params().refinement);
    filter.initialize(before, 0.02, 0.01);
    for (int i = 0; i < 40; ++i) {
      filter.predictWithOdometry(Pose::Identity(), 0.1);
      const UpdateReport report = filter.update(map, {i < 20 ? first : second});
      if (i < 20) {
        EXPECT_LT(report.injected_share, 0.3);
      }
      *share = std::max(*share, report.injected_share);
    }
    const Pose error = filter.estimate().mean.inverse() * after;
    if (error.translation().norm() < 0.05) ++count;
  }
  return count;
}

/// The same flights are run without and with injected particles.
TEST(Recovery, ACameraThatWasPushedIsFoundAgain) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  FilterParameters params;
  double share = 0;
  const int without = recovered(map, params, &share);
  EXPECT_EQ(share, 0);
  params.recovery_alpha_slow = 0.02;
  params.recovery_alpha_fast = 0.3;
  const int with = recovered(map, params, &share);
  EXPECT_GT(share, 0.1);
  EXPECT_GE(with, 14);
  EXPECT_LE(without, 4);
}

}  // namespace
}  // namespace edge_mcl
