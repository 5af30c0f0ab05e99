/// Moments that were shown, to be shown again.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Pictures are kept compressed, and only as many as the memory allows: the oldest are forgotten
/// first, with particles and depth. Poses and figures stay.
class MomentStore {
 public:
  explicit MomentStore(size_t most_bytes) : most_bytes_(most_bytes) {}

  void add(const ViewMoment& moment);
  size_t size() const { return moments_.size(); }
  /// @throws Error beyond the end.
  ViewMoment get(size_t i) const;
  LocalizerState stateOf(size_t i) const { return moments_[i].moment.state; }
  double timeOf(size_t i) const { return moments_[i].moment.time; }
  /// Of what may be forgotten.
  size_t bytes() const { return bytes_; }

 private:
  struct Stored {
    ViewMoment moment;  // without what follows
    std::vector<uint8_t> image, mask;
    std::vector<std::array<float, 7>> particles;  // position and quaternion
    size_t bytes() const;
  };
  size_t most_bytes_, bytes_ = 0, forgotten_ = 0;
  std::deque<Stored> moments_;
};

}  // namespace edge_mcl
