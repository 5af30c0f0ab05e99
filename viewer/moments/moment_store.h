/// Stores moments so that the viewer can show them again.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Keeps images and masks compressed. When they need more than the allowed memory, the oldest
/// moments lose image, mask, particles and depth points. Poses and figures of all moments stay.
class MomentStore {
 public:
  /// @param most_bytes limit of bytes(). The newest moment is kept in full even above it.
  explicit MomentStore(size_t most_bytes) : most_bytes_(most_bytes) {}

  void add(const ViewMoment& moment);
  size_t size() const { return moments_.size(); }
  /// Returns moment number i, from 0 on. @throws Error when there is none.
  ViewMoment get(size_t i) const;
  LocalizerState stateOf(size_t i) const { return moments_[i].moment.state; }
  double timeOf(size_t i) const { return moments_[i].moment.time; }
  /// Memory of images, masks, particles and depth points, bytes.
  size_t bytes() const { return bytes_; }

 private:
  struct Stored {
    ViewMoment moment;  // without image, mask and particles
    std::vector<uint8_t> image, mask;
    std::vector<std::array<float, 7>> particles;  // position and quaternion
    size_t bytes() const;
  };
  size_t most_bytes_, bytes_ = 0, forgotten_ = 0;
  std::deque<Stored> moments_;
};

}  // namespace edge_mcl
