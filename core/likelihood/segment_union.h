/// A set of segment numbers with ranks. It merges the visible sets of several cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace edge_mcl {

/// Set of segment numbers, with one bit per segment of the model. So merging needs no sorting.
class SegmentUnion {
 public:
  explicit SegmentUnion(size_t segments) : bits_((segments + 63) / 64, 0) {}

  void insert(uint32_t index) { bits_[index / 64] |= uint64_t{1} << index % 64; }

  /// Removes the numbers for which `keep` is false. Afterwards rank() is valid.
  /// @return the remaining numbers, ascending.
  template <class Keep>
  std::vector<uint32_t> filter(const Keep& keep) {
    std::vector<uint32_t> kept;
    before_.resize(bits_.size());
    for (size_t w = 0; w < bits_.size(); ++w) {
      before_[w] = static_cast<uint32_t>(kept.size());
      for (uint64_t left = bits_[w]; left != 0; left &= left - 1) {
        const auto index = static_cast<uint32_t>(64 * w) + lowestBit(left);
        if (keep(index))
          kept.push_back(index);
        else
          bits_[w] &= ~(uint64_t{1} << index % 64);
      }
    }
    return kept;
  }

  /// Position of a number among the remaining numbers; -1 when it is not among them.
  int32_t rank(uint32_t index) const {
    const uint64_t bit = uint64_t{1} << index % 64, word = bits_[index / 64];
    if (!(word & bit)) return -1;
    return static_cast<int32_t>(before_[index / 64]) + __builtin_popcountll(word & (bit - 1));
  }

 private:
  static uint32_t lowestBit(uint64_t word) { return static_cast<uint32_t>(__builtin_ctzll(word)); }
  std::vector<uint64_t> bits_;
  std::vector<uint32_t> before_;  // remaining numbers before each word
};

}  // namespace edge_mcl
