/// What has been so far: for the strips and the paths.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// What is remembered of a moment.
struct HistoryEntry {
  double time = 0;
  LocalizerState state = LocalizerState::kUninitialized;
  std::optional<Eigen::Vector3f> position, truth;         ///< of the base, map
  std::optional<double> error_position, error_angle_deg;  ///< where the truth is known; m
  double std_position = 0;                                ///< m, largest axis
  double effective_sample_size = 0;
  UpdateTimes times;
};
HistoryEntry entryOf(const ViewMoment& moment);

/// What is drawn of the history at a moment.
struct HistoryView {
  std::vector<HistoryEntry> strip;                ///< the last seconds, oldest first
  std::vector<Eigen::Vector3f> path, truth_path;  ///< thinned out where very long
};

/// Bounded: the oldest moments are forgotten.
class ViewHistory {
 public:
  static constexpr size_t kMost = 20000;  ///< moments

  void add(const ViewMoment& moment);
  void clear() { entries_.clear(); }
  size_t size() const { return entries_.size(); }
  const HistoryEntry& operator[](size_t i) const { return entries_[i]; }
  /// @param until as if only so many moments had been.
  HistoryView view(size_t until, double seconds) const;

 private:
  std::deque<HistoryEntry> entries_;
};

}  // namespace edge_mcl
