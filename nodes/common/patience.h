/// Waiting for what comes a little late, and not for what does not come at all.
#pragma once

#include <algorithm>

namespace edge_mcl {

/// What was missing several times in a row is not awaited, so that every image is not late for it.
/// When something newer of its kind shows that it comes again, it is awaited once more; where that
/// was in vain it is tried again after more and more times. Not thread-safe.
class Patience {
 public:
  /// @param newest stamp of the newest that is there, s; anything as long as there is none.
  /// @return whether the next one is worth waiting for.
  bool isWorthwhile(double newest) const {
    return missed_ <= kMost || (newest != newest_then_ && since_trial_ >= pause_);
  }
  void found() { missed_ = since_trial_ = pause_ = 0; }
  /// @param waited for it in vain; else it was not waited for.
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
  static constexpr int kMost = 3, kLongestPause = 63;
  int missed_ = 0;  // times in a row
  int since_trial_ = 0, pause_ = 0;
  double newest_then_ = 0;
};

}  // namespace edge_mcl
