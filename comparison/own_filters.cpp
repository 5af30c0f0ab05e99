#include "edge_mcl/comparison/own_filters.h"

namespace edge_mcl {

OwnFilter::OwnFilter(std::shared_ptr<const LocalizationMap> map) : localizer_(std::move(map)) {
  // As for all recordings: what they show is to be tracked, however little of the image it is.
  TrackingParameters tracking = localizer_.tracking();
  tracking.min_visible_samples = 0;
  localizer_.setTracking(tracking);
}

Pose OwnFilter::process(const LiveInput& input, const Pose&) {
  return localizer_.process(input).estimate.mean;
}

Pose DeadReckoning::process(const LiveInput& input, const Pose&) {
  pose_ = normalized(pose_ * motion_.next(input).increment);
  return pose_;
}

}  // namespace edge_mcl
