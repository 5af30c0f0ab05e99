#include "edge_mcl/viewer/moments/view_history.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

HistoryEntry entryOf(const ViewMoment& m) {
  HistoryEntry e;
  e.time = m.time;
  e.state = m.state;
  e.effective_sample_size = m.effective_sample_size;
  e.times = m.times;
  if (m.truth) e.truth = m.truth->translation().cast<float>();
  if (!m.has_pose) return e;
  e.position = m.estimate.mean.translation().cast<float>();
  e.std_position = std::sqrt(m.estimate.covariance.diagonal().head<3>().maxCoeff());
  if (m.truth) {
    e.error_position = (m.estimate.mean.translation() - m.truth->translation()).norm();
    e.error_angle_deg = rotationAngle(m.estimate.mean, *m.truth) * 180 / M_PI;
  }
  return e;
}

void ViewHistory::add(const ViewMoment& moment) {
  entries_.push_back(entryOf(moment));
  if (entries_.size() > kMost) entries_.pop_front();
}

HistoryView ViewHistory::view(size_t until, double seconds) const {
  HistoryView view;
  until = std::min(until, entries_.size());
  if (until == 0) return view;
  const double now = entries_[until - 1].time;
  size_t first = until;
  while (first > 0 && entries_[first - 1].time >= now - seconds) --first;
  const auto at = [&](size_t i) { return entries_.begin() + static_cast<long>(i); };
  view.strip.assign(at(first), at(until));
  constexpr size_t kPathPoints = 2000;
  const size_t step = until / kPathPoints + 1;
  for (size_t i = 0; i < until; ++i) {
    if (i % step != 0 && i + 1 != until) continue;
    if (entries_[i].position) view.path.push_back(*entries_[i].position);
    if (entries_[i].truth) view.truth_path.push_back(*entries_[i].truth);
  }
  return view;
}

}  // namespace edge_mcl
