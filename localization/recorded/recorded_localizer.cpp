#include "edge_mcl/localization/recorded/recorded_localizer.h"

#include <chrono>
#include <utility>

namespace edge_mcl {

TrackingParameters trackingOfRecordings(TrackingParameters tracking) {
  tracking.min_visible_samples = 0;
  return tracking;
}

RecordedLocalizer::RecordedLocalizer(std::shared_ptr<const LocalizationMap> map,
                                     std::unique_ptr<RecordedInput> input,
                                     const RecordedStart& start)
    : recording_(std::move(input)), localizer_(std::move(map)), up_base_(start.up_base) {
  localizer_.setTracking(trackingOfRecordings(localizer_.tracking()));
  if (start.pose)
    localizer_.setPose(*start.pose);
  else
    localizer_.searchEverywhere();
}

bool RecordedLocalizer::next() {
  std::string problem;
  const auto begin = std::chrono::steady_clock::now();
  if (!recording_->next(&input_, &problem)) return false;
  reading_ms_ =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  if (up_base_) {
    input_.up.emplace();
    input_.up->up_base = up_base_->normalized();
    up_base_.reset();
  }
  result_ = localizer_.process(input_);
  if (!problem.empty()) result_.problem = problem;
  return true;
}

}  // namespace edge_mcl
