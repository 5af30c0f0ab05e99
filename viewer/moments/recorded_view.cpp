#include "edge_mcl/viewer/moments/recorded_view.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

RecordedView::RecordedView(std::shared_ptr<const LocalizationMap> map,
                           std::unique_ptr<RecordedInput> input, const RecordedStart& start,
                           size_t max_particles)
    : localizer_(std::move(map), std::move(input), start), max_particles_(max_particles) {}

std::optional<Pose> RecordedView::truthAt(double time) const {
  const Trajectory& truth = localizer_.recording().truth();
  constexpr double kSameMoment = 0.02;  // s
  const auto after = std::lower_bound(truth.begin(), truth.end(), time,
                                      [](const StampedPose& p, double t) { return p.time < t; });
  std::optional<Pose> nearest;
  double best = kSameMoment;
  for (auto it = after == truth.begin() ? after : after - 1; it != truth.end() && it <= after; ++it)
    if (std::abs(it->time - time) <= best) {
      best = std::abs(it->time - time);
      nearest = it->pose;
    }
  return nearest;
}

bool RecordedView::next(ViewMoment* moment) {
  if (!localizer_.next()) return false;
  const LiveInput& input = localizer_.input();
  *moment = momentOf(input, localizer_.result(), localizer_.localizer(), truthAt(input.time),
                     max_particles_);
  if (!first_time_) first_time_ = input.time;
  moment->elapsed = input.time - *first_time_;
  return true;
}

}  // namespace edge_mcl
