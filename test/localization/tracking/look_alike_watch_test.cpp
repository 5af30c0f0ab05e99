#include "edge_mcl/localization/tracking/look_alike_watch.h"

#include <gtest/gtest.h>

#include "support/stairs.h"

namespace edge_mcl {
namespace {

class LookAlikeWatchTest : public testing::Test {
 protected:
  LookAlikeWatchTest() {
    const CameraModel camera = test::pinhole(320, 240, 220);
    const auto image = map_.prepare(camera, test::render(map_.mesh(), camera, true_), {}, "stairs");
    views_ = {{image, Pose::Identity(), 1, nullptr}};
    wrong_.translation() += test::oneStep();
  }

  const LocalizationMap map_{test::stairs(), Parameters()};
  const Pose true_ = test::beforeStairs();
  Pose wrong_ = true_;
  std::vector<CameraView> views_;
  LookAlikeWatch watch_;
};

TEST_F(LookAlikeWatchTest, ABetterPoseIsTakenWhenItIsBetterTwice) {
  const LookAlikeWatch::Result first = watch_.look(map_, views_, wrong_, 1.0);
  EXPECT_FALSE(first.log_odds.has_value());
  EXPECT_FALSE(first.better.has_value());
  const LookAlikeWatch::Result second = watch_.look(map_, views_, wrong_, 1.03);
  ASSERT_TRUE(second.log_odds.has_value());
  EXPECT_LT(*second.log_odds, -4);
  ASSERT_TRUE(second.better.has_value());
  EXPECT_LT((second.better->translation() - true_.translation()).norm(), 0.03);
}

/// What fits by chance fits elsewhere in the next image.
TEST_F(LookAlikeWatchTest, TwoDifferentOnesAreNotOneThatIsBetterTwice) {
  const CameraModel camera = test::pinhole(320, 240, 220);
  for (const double step : {-1.0, 1.0}) {
    Pose seen = wrong_;
    seen.translation() += step * test::oneStep();
    const auto image = map_.prepare(camera, test::render(map_.mesh(), camera, seen), {}, "stairs");
    const auto result =
        watch_.look(map_, {{image, Pose::Identity(), 1, nullptr}}, wrong_, 1 + step);
    EXPECT_FALSE(result.log_odds.has_value()) << step;
    EXPECT_FALSE(result.better.has_value()) << step;
  }
}

TEST_F(LookAlikeWatchTest, ANewPoseBeginsAgain) {
  watch_.look(map_, views_, wrong_, 1.0);
  watch_.begin();
  EXPECT_FALSE(watch_.look(map_, views_, wrong_, 1.03).better.has_value());
}

TEST_F(LookAlikeWatchTest, ATruePoseStays) {
  for (int i = 0; i < 40; ++i)
    EXPECT_FALSE(watch_.look(map_, views_, true_, 0.03 * i).better.has_value());
}

/// A clock that jumps back must not silence the watch.
TEST_F(LookAlikeWatchTest, AfterAJumpOfTheClockItAsksAgain) {
  watch_.look(map_, views_, true_, 1000);
  watch_.look(map_, views_, wrong_, 1);
  EXPECT_TRUE(watch_.look(map_, views_, wrong_, 1.03).log_odds.has_value());
}

}  // namespace
}  // namespace edge_mcl
