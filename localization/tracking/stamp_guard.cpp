#include "edge_mcl/localization/tracking/stamp_guard.h"

#include <algorithm>

#include "edge_mcl/core/base/clock_step.h"

namespace edge_mcl {

namespace {

/// Before two images have come in order, a camera is assumed to send 30 of them in a second.
constexpr double kUsualInterval = 1.0 / 30;  // s
/// A recording may pause for seconds. Without odometry a pause longer than this has lost the pose
/// anyway, so one more image does no harm.
constexpr double kPause = 10;  // s

}  // namespace

StampGuard::Verdict StampGuard::judge(double stamp, bool is_known) {
  if (!last_) return accepted(stamp, Verdict::kInOrder);
  switch (clockStep(*last_, stamp)) {
    case ClockStep::kLate:
      return late();
    case ClockStep::kJumpedBack:
      // A stamp before an unconfirmed one ahead does not come here, because that one was not used.
      if (returnsFromJump(stamp)) {
        jump_.reset();
        return accepted(stamp, Verdict::kReturned);
      }
      jump_.reset();
      return accepted(stamp, Verdict::kJumpedBack);
    case ClockStep::kForward:
      break;
  }
  if (isTooFarAhead(stamp, is_known)) return Verdict::kAhead;
  // The mean forgets an interval after some five images.
  constexpr double kNew = 0.2;
  const double gap = stamp - *last_;
  if (gap > kPause) jump_ = Jump{*last_, stamp};
  interval_ = interval_ > 0 ? (1 - kNew) * interval_ + kNew * gap : gap;
  return accepted(stamp, Verdict::kInOrder);
}

bool StampGuard::returnsFromJump(double stamp) const {
  // As much time has passed before the jump as after it.
  return jump_ && stamp > jump_->before && stamp < jump_->before + (*last_ - jump_->after) + kPause;
}

StampGuard::Verdict StampGuard::accepted(double stamp, Verdict verdict) {
  last_ = stamp;
  ahead_.reset();
  stalled_ = 0;
  return verdict;
}

StampGuard::Verdict StampGuard::late() {
  // Images that overtake each other are late one or two at a time.
  constexpr double kOvertaking = 0.35;  // s
  stalled_ += interval_ > 0 ? interval_ : kUsualInterval;
  return stalled_ > std::max(kOvertaking, 2.5 * interval_) ? Verdict::kStandsStill : Verdict::kLate;
}

bool StampGuard::isTooFarAhead(double stamp, bool is_known) {
  constexpr double kUsual = 10;  // usual intervals, for cameras that send few images
  const double gap = stamp - *last_;
  const double limit = std::max(kPause, kUsual * interval_);
  if (is_known || gap <= limit) return false;
  // The next image confirms the jump when it follows at the new time.
  if (ahead_ && stamp > *ahead_ && stamp - *ahead_ <= std::max(limit, *ahead_ - *last_))
    return false;
  ahead_ = stamp;
  return true;
}

}  // namespace edge_mcl
