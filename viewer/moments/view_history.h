/// Keeps the history of poses and figures for the strips and the paths.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Figures of one moment that the history keeps.
struct HistoryEntry {
  double time = 0;  ///< s
  LocalizerState state = LocalizerState::kUninitialized;
  std::optional<Eigen::Vector3f> position, truth;         ///< of the base, map, m
  std::optional<double> error_position, error_angle_deg;  ///< only with ground truth; m, deg
  double std_position = 0;                                ///< m, of the largest axis
  double effective_sample_size = 0;
  UpdateTimes times;
};
/// Takes the figures out of a moment.
HistoryEntry entryOf(const ViewMoment& moment);

/// Part of the history that is drawn.
struct HistoryView {
  std::vector<HistoryEntry> strip;                ///< the last seconds, oldest first
  std::vector<Eigen::Vector3f> path, truth_path;  ///< map, m; thinned out to about 2000 points
};

/// A list of moments of limited length. Beyond kMost the oldest moments are dropped.
class ViewHistory {
 public:
  static constexpr size_t kMost = 20000;  ///< moments

  void add(const ViewMoment& moment);
  void clear() { entries_.clear(); }
  size_t size() const { return entries_.size(); }
  const HistoryEntry& operator[](size_t i) const { return entries_[i]; }
  /// Returns what to draw. @param until number of moments to use, from the oldest on.
  /// @param seconds time span of the strips before the last of these moments.
  HistoryView view(size_t until, double seconds) const;

 private:
  std::deque<HistoryEntry> entries_;
};

}  // namespace edge_mcl
