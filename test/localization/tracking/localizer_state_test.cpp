#include "edge_mcl/localization/tracking/localizer_state.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

constexpr double kLostAfter = 1.5;

/// A machine in a given state, at time 0.
StateMachine machineIn(LocalizerState state) {
  StateMachine m;
  switch (state) {
    case LocalizerState::kUninitialized:
      break;
    case LocalizerState::kSearching:
      m.forgetPose();
      break;
    case LocalizerState::kConverging:
      m.givePose();
      m.judge({0, true, true, false}, kLostAfter);
      break;
    case LocalizerState::kTracking:
      m.givePose();
      m.judge({0, true, true, true}, kLostAfter);
      break;
    case LocalizerState::kDegraded:
      m.givePose();
      m.judge({0, true, true, true}, kLostAfter);
      m.judge({0, true, false, true}, kLostAfter);
      break;
    case LocalizerState::kLost:
      m.givePose();
      m.judge({-kLostAfter, true, true, true}, kLostAfter);
      m.judge({0, true, false, true}, kLostAfter);
      break;
  }
  EXPECT_EQ(m.state(), state);
  return m;
}

constexpr LocalizerState kAll[] = {LocalizerState::kUninitialized, LocalizerState::kConverging,
                                   LocalizerState::kTracking,      LocalizerState::kDegraded,
                                   LocalizerState::kLost,          LocalizerState::kSearching};
constexpr LocalizerState kWithPose[] = {LocalizerState::kConverging, LocalizerState::kTracking,
                                        LocalizerState::kDegraded, LocalizerState::kLost};

/// The table in the header, row by row.
TEST(StateMachine, AGivenPoseConvergesFromEveryState) {
  for (const LocalizerState state : kAll) {
    StateMachine m = machineIn(state);
    m.givePose();
    EXPECT_EQ(m.state(), LocalizerState::kConverging) << nameOf(state);
    EXPECT_FALSE(m.trusted());
    m.forgetPose();
    EXPECT_EQ(m.state(), LocalizerState::kSearching) << nameOf(state);
  }
}

/// A pose that is likely right is lost later than a doubtful one.
TEST(StateMachine, ALikelyPoseIsLostLater) {
  StateMachine m = machineIn(LocalizerState::kTracking);
  StateInput likely{2 * kLostAfter, true, false, true};
  likely.doubtful = false;
  m.judge(likely, kLostAfter);
  EXPECT_EQ(m.state(), LocalizerState::kDegraded);
  likely.time = 5 * kLostAfter;
  m.judge(likely, kLostAfter);
  EXPECT_EQ(m.state(), LocalizerState::kLost);
}

TEST(StateMachine, ATrustedPoseTracksWhenItIsNarrow) {
  for (const LocalizerState state : kWithPose) {
    StateMachine m = machineIn(state);
    m.judge({0.1, true, true, true}, kLostAfter);
    EXPECT_EQ(m.state(), LocalizerState::kTracking) << nameOf(state);
    EXPECT_TRUE(m.trusted());
    m = machineIn(state);
    m.judge({0.1, true, true, false}, kLostAfter);
    EXPECT_EQ(m.state(), LocalizerState::kConverging) << nameOf(state);
  }
}

TEST(StateMachine, WithoutTrustItDegradesAndThenIsLost) {
  for (const LocalizerState state : kWithPose) {
    StateMachine m = machineIn(state);
    m.judge({kLostAfter + 0.1, true, false, true}, kLostAfter);
    EXPECT_EQ(m.state(), LocalizerState::kLost) << nameOf(state);
    m = machineIn(state);
    m.judge({0.1, true, false, true}, kLostAfter);
    EXPECT_EQ(m.state(), state == LocalizerState::kTracking ? LocalizerState::kDegraded : state)
        << nameOf(state);
    m = machineIn(state);
    m.judge({0.1, false, false, true}, kLostAfter);  // the image could not be used
    EXPECT_EQ(m.state(),
              state == LocalizerState::kLost ? LocalizerState::kLost : LocalizerState::kDegraded)
        << nameOf(state);
  }
}

TEST(StateMachine, WithoutAPoseImagesChangeNothing) {
  for (const LocalizerState state : {LocalizerState::kUninitialized, LocalizerState::kSearching}) {
    StateMachine m = machineIn(state);
    m.judge({100, true, true, true}, kLostAfter);
    EXPECT_EQ(m.state(), state);
  }
}

TEST(StateMachine, TheTimeWithoutTrustStartsWithTheFirstImageAndCanBeExcused) {
  StateMachine m;
  m.givePose();
  m.judge({100, true, false, true}, kLostAfter);  // the first image, however late it is
  EXPECT_EQ(m.state(), LocalizerState::kConverging);
  EXPECT_EQ(m.timeWithoutTrust(101), 1);
  m.excuse(101);
  m.judge({102, true, false, true}, kLostAfter);
  EXPECT_EQ(m.state(), LocalizerState::kConverging);
  m.judge({102.5, true, false, true}, kLostAfter);
  EXPECT_EQ(m.state(), LocalizerState::kLost);
}

TEST(StateMachine, StatesHaveNames) {
  EXPECT_STREQ(nameOf(LocalizerState::kTracking), "tracking");
  EXPECT_STREQ(nameOf(LocalizerState::kUninitialized), "uninitialized");
}

}  // namespace
}  // namespace edge_mcl
