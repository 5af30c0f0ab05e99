/// The state that the localizer reports with a pose, and the transitions between states.
#pragma once

#include <optional>

namespace edge_mcl {

/// See the table of states in docs/search.md.
enum class LocalizerState { kUninitialized, kConverging, kTracking, kDegraded, kLost, kSearching };

/// "tracking" etc.
const char* nameOf(LocalizerState state);

/// What an image told about the pose.
struct StateInput {
  double time = 0;       ///< s
  bool used = false;     ///< the image was compared with the model
  bool trusted = false;  ///< the pose is proven, see PoseProof
  bool narrow = false;   ///< the covariance is below `tracking.converged_std_*`
  /// The probability is below `tracking.lost_probability`, or the image was not used.
  bool doubtful = true;
};

/// Holds the state. Every transition is one of these calls.
///
/// | call | from | to |
/// |---|---|---|
/// | `givePose` | any | converging |
/// | `forgetPose` | any | searching |
/// | `judge`, trusted and narrow | any but uninitialized, searching | tracking |
/// | `judge`, trusted, not narrow | any but uninitialized, searching | converging |
/// | `judge`, not trusted for too long | any but uninitialized, searching | lost |
/// | `judge`, not trusted | tracking | degraded |
/// | `judge`, not trusted, image not used | converging | degraded |
///
/// Too long is `lost_after` for a doubtful pose and four times as long for another.
class StateMachine {
 public:
  LocalizerState state() const { return state_; }
  /// Whether the pose was trusted at the last judged image.
  bool trusted() const { return trusted_; }
  /// Time since the pose was trusted last, or since the first image after it was given, s.
  double timeWithoutTrust(double time) const { return trusted_at_ ? time - *trusted_at_ : 0; }

  /// A pose was given or found.
  void givePose();
  /// There is no pose; it is searched in the whole model.
  void forgetPose();
  /// No image can contradict the pose now: the robot rests, or there was no image.
  void excuse(double time) { trusted_at_ = time; }
  /// An image was judged, or could not be used.
  /// @param lost_after `tracking.lost_after`, s
  void judge(const StateInput& input, double lost_after);

 private:
  LocalizerState state_ = LocalizerState::kUninitialized;
  bool trusted_ = false;
  std::optional<double> trusted_at_;
};

}  // namespace edge_mcl
