/// Waiting for what comes a little late, and not for what does not come at all.
#pragma once

namespace edge_mcl {

/// What was missing several times in a row is not awaited, so that every image is not late for it,
/// until something newer of its kind shows that it comes again. Not thread-safe.
class Patience {
 public:
  /// @param newest stamp of the newest that is there, s; anything as long as there is none.
  /// @return whether the next one is worth waiting for.
  bool isWorthwhile(double newest) const { return missed_ <= kMost || newest != newest_then_; }
  void found() { missed_ = 0; }
  void missed(double newest) {
    ++missed_;
    newest_then_ = newest;
  }

 private:
  static constexpr int kMost = 3;
  int missed_ = 0;  // times in a row
  double newest_then_ = 0;
};

}  // namespace edge_mcl
