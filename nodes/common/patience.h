/// Decides whether late data are worth waiting for, and waits.
#pragma once

#include <algorithm>
#include <optional>

namespace edge_mcl {

/// Remembers how often data of one kind were missing.
///
/// After four misses in a row nobody waits any more, so that images are not delayed for data that
/// do not come. When newer data of that kind arrive, one more wait is tried. Each wait in vain
/// makes the pause before the next trial longer. Not thread-safe.
class Patience {
 public:
  /// @param newest stamp of the newest data of this kind, s; any value when there are none
  /// @return whether to wait for the next data
  bool isWorthwhile(double newest) const {
    return missed_ <= kMost || (newest != newest_then_ && since_trial_ >= pause_);
  }
  void found() { missed_ = since_trial_ = pause_ = 0; }
  /// @param waited true: the wait was in vain; false: nobody waited
  void missed(double newest, bool waited) {
    newest_then_ = newest;
    if (++missed_ <= kMost + 1) return;
    missed_ = kMost + 1;
    ++since_trial_;
    if (!waited) return;
    since_trial_ = 0;
    pause_ = std::min(kLongestPause, 2 * pause_ + 1);
  }

 private:
  // Three misses happen by chance in a busy system. The longest pause is two seconds of a 30 Hz
  // camera, so a source that returns is used again soon.
  static constexpr int kMost = 3, kLongestPause = 63;  // misses, images
  int missed_ = 0;                                     // in a row
  int since_trial_ = 0, pause_ = 0;
  double newest_then_ = 0;
};

/// One look at data that may be there.
template <class Data>
struct Look {
  std::optional<Data> found;
  bool may_come = false;      ///< the data are missing and may still arrive
  bool has_own_wait = false;  ///< the data wait for something with a time limit of its own
  double newest = 0;          ///< stamp of the newest data of this kind, s
};

/// Looks again and again until data are found, a deadline passes or waiting is not worthwhile.
/// @param look returns a Look; @param may_go_on false: the deadline has passed; @param pause waits
/// a little; @param running false: the node ends
template <class Data, class LookAt, class MayGoOn, class Pause, class Running>
std::optional<Data> awaitData(Patience* patience, LookAt&& look, MayGoOn&& may_go_on, Pause&& pause,
                              Running&& running) {
  bool waited = false;
  while (running()) {
    const Look<Data> now = look();
    if (now.found) {
      patience->found();
      return now.found;
    }
    const bool awaited =
        now.may_come && may_go_on() && (waited || patience->isWorthwhile(now.newest));
    if (!awaited && !now.has_own_wait) {
      if (now.may_come) patience->missed(now.newest, waited);
      return std::nullopt;
    }
    waited |= awaited;
    pause();
  }
  return std::nullopt;
}

}  // namespace edge_mcl
