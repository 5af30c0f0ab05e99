#include "edge_mcl/viewer/moments/recorded_view.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

RecordedView::RecordedView(std::shared_ptr<const LocalizationMap> map,
                           std::unique_ptr<RecordedInput> input, std::optional<PoseGaussian> start,
                           std::optional<Eigen::Vector3d> up_base, size_t max_particles)
    : input_(std::move(input)),
      localizer_(std::move(map)),
      up_base_(std::move(up_base)),
      max_particles_(max_particles) {
  // As for every recording: it is tracked however little of the model is in the image.
  TrackingParameters tracking = localizer_.tracking();
  tracking.min_visible_samples = 0;
  localizer_.setTracking(tracking);
  if (start)
    localizer_.setPose(*start);
  else
    localizer_.searchEverywhere();
}

std::optional<Pose> RecordedView::truthAt(double time) const {
  const Trajectory& truth = input_->truth();
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
  LiveInput input;
  std::string problem;
  if (!input_->next(&input, &problem)) return false;
  if (up_base_) {
    input.up.emplace();
    input.up->up_base = up_base_->normalized();
    up_base_.reset();
  }
  const LiveResult result = localizer_.process(input);
  *moment = momentOf(input, result, localizer_, truthAt(input.time), max_particles_);
  if (!problem.empty()) moment->problem = problem;
  if (!first_time_) first_time_ = input.time;
  moment->elapsed = input.time - *first_time_;
  return true;
}

}  // namespace edge_mcl
