#include "edge_mcl/localization/tracking/localizer_state.h"

namespace edge_mcl {

namespace {

/// A pose that is not doubtful is lost only after this many times `lost_after` without trust:
/// images of a whole room should have confirmed it by then.
constexpr double kPatience = 4;

}  // namespace

const char* nameOf(LocalizerState state) {
  switch (state) {
    case LocalizerState::kUninitialized:
      return "uninitialized";
    case LocalizerState::kConverging:
      return "converging";
    case LocalizerState::kTracking:
      return "tracking";
    case LocalizerState::kDegraded:
      return "degraded";
    case LocalizerState::kLost:
      return "lost";
    case LocalizerState::kSearching:
      return "searching";
  }
  return "?";
}

void StateMachine::givePose() {
  state_ = LocalizerState::kConverging;
  trusted_ = false;
  trusted_at_.reset();
}

void StateMachine::forgetPose() {
  state_ = LocalizerState::kSearching;
  trusted_ = false;
  trusted_at_.reset();
}

void StateMachine::judge(const StateInput& input, double lost_after) {
  if (state_ == LocalizerState::kUninitialized || state_ == LocalizerState::kSearching) return;
  if (!trusted_at_ || input.trusted) trusted_at_ = input.time;
  trusted_ = input.trusted;
  if (input.trusted)
    state_ = input.narrow ? LocalizerState::kTracking : LocalizerState::kConverging;
  else if (timeWithoutTrust(input.time) >= (input.doubtful ? 1 : kPatience) * lost_after)
    state_ = LocalizerState::kLost;
  else if (state_ == LocalizerState::kTracking ||
           (state_ == LocalizerState::kConverging && !input.used))
    state_ = LocalizerState::kDegraded;
}

}  // namespace edge_mcl
