#include "edge_mcl/localization/recorded/sequence_localizer.h"

#include <chrono>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/recorded/sequence_input.h"

namespace edge_mcl {

SequenceLocalizer::SequenceLocalizer(const LocalizationMap& map, const Sequence& sequence,
                                     bool use_masks)
    : map_(map),
      sequence_(sequence),
      use_masks_(use_masks),
      // The map is the caller's: shared without owning it.
      localizer_(std::shared_ptr<const LocalizationMap>(std::shared_ptr<const void>(), &map)) {
  if (sequence.initial_pose)
    setInitialSpread(sequence.initial_std_position, sequence.initial_std_angle);
  // A recording is of what is to be tracked, however little of the image that is.
  TrackingParameters tracking = localizer_.tracking();
  tracking.min_visible_samples = 0;
  localizer_.setTracking(tracking);
}

void SequenceLocalizer::setInitialSpread(double std_position, double std_angle) {
  localizer_.setPose(initialGaussian(sequence_, std_position, std_angle));
}

void SequenceLocalizer::searchEverywhere(const std::optional<Eigen::Vector3d>& up_camera) {
  up_camera_ = up_camera;
  localizer_.searchEverywhere();
}

LiveResult SequenceLocalizer::step() {
  if (next_ >= sequence_.frames.size()) throw Error("no more images in the sequence");
  const SequenceFrame& frame = sequence_.frames[next_];
  std::string problem;
  const auto start = std::chrono::steady_clock::now();
  LiveInput input =
      readInput(sequence_, frame, {map_.usesImages(), use_masks_, map_.usesDepth()}, &problem);
  if (next_ == 0 && up_camera_) {
    input.up.emplace();
    input.up->up_base = up_camera_->normalized();
  }
  reading_ms_ =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  ++next_;
  LiveResult result = localizer_.process(input);
  if (!problem.empty()) result.problem = problem;
  return result;
}

}  // namespace edge_mcl
