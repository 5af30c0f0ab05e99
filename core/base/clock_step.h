/// Tells late data from a clock that was set back.
#pragma once

namespace edge_mcl {

/// Data older than its predecessor by up to this, in seconds, are late. Data that are older by more
/// mean that the clock was set back: a bag that is played again, or a simulation that starts again.
/// Drivers and networks deliver within a fraction of a second, and recordings are longer than that.
constexpr double kClockJump = 1;

enum class ClockStep { kForward, kLate, kJumpedBack };

/// @param last, now time stamps in the order of arrival, s
inline ClockStep clockStep(double last, double now) {
  if (now > last) return ClockStep::kForward;
  return now >= last - kClockJump ? ClockStep::kLate : ClockStep::kJumpedBack;
}

}  // namespace edge_mcl
