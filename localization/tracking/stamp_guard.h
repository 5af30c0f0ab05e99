/// Judges the time stamps of images in the order in which the images come.
#pragma once

#include <optional>

namespace edge_mcl {

/// Cameras and drivers send stamps that cannot be true: stamps that stand still, and single stamps
/// that are hours ahead. Such an image must not move the pose, and must not keep it trusted.
class StampGuard {
 public:
  enum class Verdict {
    kInOrder,      ///< later than the one before
    kLate,         ///< not later than the one before; the image came late
    kStandsStill,  ///< the stamps have not advanced for a while
    kJumpedBack,   ///< the clock was set back
    kReturned,     ///< the clock came back to the time from which it had jumped ahead
    kAhead         ///< so far ahead that another image must confirm it
  };

  /// Judges the next stamp, s. @param is_known odometry knows this time, so the stamp is true even
  /// far ahead.
  Verdict judge(double stamp, bool is_known);
  /// Time without a usable stamp, as the usual time between images tells it, s.
  double stalled() const { return stalled_; }

 private:
  Verdict accepted(double stamp, Verdict verdict);
  Verdict late();
  bool isTooFarAhead(double stamp, bool is_known);

  /// A jump of the clock ahead, s.
  struct Jump {
    double before, after;
  };
  bool returnsFromJump(double stamp) const;

  std::optional<Jump> jump_;     // newest jump ahead
  std::optional<double> last_;   // stamp that was accepted last, s
  std::optional<double> ahead_;  // stamp that waits for confirmation, s
  double interval_ = 0;          // usual time between images, s; 0: not known
  double stalled_ = 0;
};

}  // namespace edge_mcl
