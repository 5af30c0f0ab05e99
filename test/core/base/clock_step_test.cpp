#include "edge_mcl/core/base/clock_step.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

TEST(ClockStep, TellsLateFromJumpedBack) {
  EXPECT_EQ(clockStep(10, 10.03), ClockStep::kForward);
  EXPECT_EQ(clockStep(10, 1e9), ClockStep::kForward);
  EXPECT_EQ(clockStep(10, 10), ClockStep::kLate);  // the same stamp again
  EXPECT_EQ(clockStep(10, 9.5), ClockStep::kLate);
  EXPECT_EQ(clockStep(10, 10 - kClockJump), ClockStep::kLate);
  EXPECT_EQ(clockStep(10, 8.99), ClockStep::kJumpedBack);
}

}  // namespace
}  // namespace edge_mcl
