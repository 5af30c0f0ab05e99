#include "edge_mcl/comparison/own_filters.h"

#include "edge_mcl/localization/recorded/recorded_localizer.h"

namespace edge_mcl {

OwnFilter::OwnFilter(std::shared_ptr<const LocalizationMap> map) : localizer_(std::move(map)) {
  localizer_.setTracking(trackingOfRecordings(localizer_.tracking()));
}

Pose OwnFilter::process(const LiveInput& input, const Pose&) {
  return localizer_.process(input).estimate.mean;
}

Pose DeadReckoning::process(const LiveInput& input, const Pose&) {
  pose_ = normalized(pose_ * motion_.next(input).increment);
  return pose_;
}

}  // namespace edge_mcl
