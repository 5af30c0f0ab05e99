// Tests which time stamps are believed.
#include "edge_mcl/localization/tracking/stamp_guard.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

using Verdict = StampGuard::Verdict;

/// A guard that has seen one second of a camera with 10 Hz. The last stamp is 1.
StampGuard running() {
  StampGuard guard;
  for (int i = 0; i <= 10; ++i) EXPECT_EQ(guard.judge(0.1 * i, false), Verdict::kInOrder);
  return guard;
}

TEST(StampGuard, AnImageThatWasOvertakenIsLate) {
  StampGuard guard = running();
  EXPECT_EQ(guard.judge(0.95, false), Verdict::kLate);
  EXPECT_EQ(guard.judge(1.1, false), Verdict::kInOrder);
  EXPECT_EQ(guard.stalled(), 0);
}

TEST(StampGuard, StampsThatStandStillAreTold) {
  StampGuard guard = running();
  for (int i = 1; i <= 20; ++i) {
    const Verdict verdict = guard.judge(1, true);
    EXPECT_NEAR(guard.stalled(), 0.1 * i, 1e-9);
    EXPECT_EQ(verdict, i <= 3 ? Verdict::kLate : Verdict::kStandsStill) << i;
  }
  EXPECT_EQ(guard.judge(3, false), Verdict::kInOrder);
}

TEST(StampGuard, ASlowCameraMayOvertakeToo) {
  StampGuard guard;
  for (int i = 0; i < 10; ++i) guard.judge(i, false);
  EXPECT_EQ(guard.judge(8.5, false), Verdict::kLate);
}

TEST(StampGuard, OneStampAheadIsNotBelieved) {
  StampGuard guard = running();
  EXPECT_EQ(guard.judge(86401, false), Verdict::kAhead);
  EXPECT_EQ(guard.judge(1.2, false), Verdict::kInOrder);
  EXPECT_EQ(guard.judge(86401.2, false), Verdict::kAhead);
}

TEST(StampGuard, TwoStampsAheadAreBelieved) {
  StampGuard guard = running();
  EXPECT_EQ(guard.judge(60, false), Verdict::kAhead);
  EXPECT_EQ(guard.judge(60.1, false), Verdict::kInOrder);
  EXPECT_EQ(guard.judge(60.2, false), Verdict::kInOrder);
}

TEST(StampGuard, AStampThatOdometryKnowsIsBelieved) {
  StampGuard guard = running();
  EXPECT_EQ(guard.judge(60, true), Verdict::kInOrder);
}

TEST(StampGuard, PhotographsEveryMinuteAreUsed) {
  StampGuard guard;
  int used = 0;
  for (int i = 0; i < 20; ++i) used += guard.judge(60 * i, false) == Verdict::kInOrder ? 1 : 0;
  EXPECT_EQ(used, 19);  // the first interval needs a second image
}

/// A clock that is corrected and corrected back has not moved the robot.
TEST(StampGuard, AClockThatReturnsFromAJumpIsTold) {
  StampGuard guard = running();
  for (int i = 0; i < 20; ++i) EXPECT_EQ(guard.judge(86400 + 0.1 * i, true), Verdict::kInOrder);
  EXPECT_EQ(guard.judge(3.1, true), Verdict::kReturned);
  EXPECT_EQ(guard.judge(3.2, true), Verdict::kInOrder);
  EXPECT_EQ(guard.judge(-5, true), Verdict::kJumpedBack);
  // A recording that is played again begins before the jump.
  StampGuard again = running();
  again.judge(86400, true);
  EXPECT_EQ(again.judge(0, true), Verdict::kJumpedBack);
}

TEST(StampGuard, AClockThatIsSetBackBeginsAgain) {
  StampGuard guard = running();
  EXPECT_EQ(guard.judge(-5, false), Verdict::kJumpedBack);
  EXPECT_EQ(guard.judge(-4.9, false), Verdict::kInOrder);
}

}  // namespace
}  // namespace edge_mcl
