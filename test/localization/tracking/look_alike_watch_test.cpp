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

  static Matrix6 known(double sigma = 0.01) { return sigma * sigma * Matrix6::Identity(); }

  const LocalizationMap map_{test::stairs(), Parameters()};
  const Pose true_ = test::beforeStairs();
  Pose wrong_ = true_;
  std::vector<CameraView> views_;
  LookAlikeWatch watch_;
};

TEST_F(LookAlikeWatchTest, ABetterPoseIsTakenWhenItIsBetterTwice) {
  const LookAlikeWatch::Result first = watch_.look(map_, views_, wrong_, known(), 1.0);
  EXPECT_FALSE(first.log_odds.has_value());
  EXPECT_FALSE(first.better.has_value());
  const LookAlikeWatch::Result second = watch_.look(map_, views_, wrong_, known(), 1.03);
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
        watch_.look(map_, {{image, Pose::Identity(), 1, nullptr}}, wrong_, known(), 1 + step);
    EXPECT_FALSE(result.log_odds.has_value()) << step;
    EXPECT_FALSE(result.better.has_value()) << step;
  }
}

TEST_F(LookAlikeWatchTest, ANewPoseBeginsAgain) {
  watch_.look(map_, views_, wrong_, known(), 1.0);
  watch_.begin();
  EXPECT_FALSE(watch_.look(map_, views_, wrong_, known(), 1.03).better.has_value());
}

TEST_F(LookAlikeWatchTest, ATruePoseStays) {
  for (int i = 0; i < 40; ++i)
    EXPECT_FALSE(watch_.look(map_, views_, true_, known(), 0.03 * i).better.has_value());
}

/// A stair without its ends in view: the image fits one step on as well. Odometry knows which step
/// it is, unless the pose is known to half a metre only.
TEST_F(LookAlikeWatchTest, MotionTellsStepsApartThatLookTheSame) {
  const CameraModel narrow = test::pinhole(320, 240, 900);
  const auto image =
      map_.prepare(narrow, test::render(map_.mesh(), narrow, true_), {}, "only steps");
  const std::vector<CameraView> steps = {{image, Pose::Identity(), 1, nullptr}};
  const auto sure = watch_.look(map_, steps, true_, known(), 1);
  ASSERT_TRUE(sure.log_odds.has_value());
  watch_.begin();
  const auto unsure = watch_.look(map_, steps, true_, known(0.5), 1);
  ASSERT_TRUE(unsure.log_odds.has_value());
  EXPECT_NEAR(*unsure.log_odds, *sure.log_odds, 1e-6);  // the image says the same
  // Half of the squared distance. The look-alike may be some centimetres beside the step.
  const double step = test::oneStep().norm();
  EXPECT_NEAR(unsure.by_motion, step * step / (2 * 0.5 * 0.5), 0.05);
  EXPECT_EQ(sure.by_motion, 3);
}

/// A clock that jumps back must not silence the watch.
TEST_F(LookAlikeWatchTest, AfterAJumpOfTheClockItAsksAgain) {
  watch_.look(map_, views_, true_, known(), 1000);
  watch_.look(map_, views_, wrong_, known(), 1);
  EXPECT_TRUE(watch_.look(map_, views_, wrong_, known(), 1.03).log_odds.has_value());
}

}  // namespace
}  // namespace edge_mcl
