#include "edge_mcl/mrpt_plugins/sequence_localizer.h"

#include <chrono>

#include "edge_mcl/core/error.h"

namespace edge_mcl {

SequenceLocalizer::SequenceLocalizer(const LocalizationMap& map, const Sequence& sequence,
                                     bool use_masks)
    : map_(map),
      sequence_(sequence),
      use_masks_(use_masks),
      // The map is the caller's: shared without owning it.
      localizer_(std::shared_ptr<const LocalizationMap>(std::shared_ptr<const void>(), &map)) {
  setInitialSpread(sequence.initial_std_position, sequence.initial_std_angle);
  // A recording is of what is to be tracked, however little of the image that is.
  TrackingParameters tracking = localizer_.tracking();
  tracking.min_visible_samples = 0;
  localizer_.setTracking(tracking);
}

void SequenceLocalizer::setInitialSpread(double std_position, double std_angle) {
  PoseGaussian initial;
  initial.mean = sequence_.initial_pose;
  initial.covariance.diagonal().head<3>().setConstant(std_position * std_position);
  initial.covariance.diagonal().tail<3>().setConstant(std_angle * std_angle);
  localizer_.setPose(initial);
}

void SequenceLocalizer::searchEverywhere(const std::optional<Eigen::Vector3d>& up_camera) {
  up_camera_ = up_camera;
  localizer_.searchEverywhere();
}

LiveInput SequenceLocalizer::read(const SequenceFrame& frame, std::string* problem) {
  LiveInput input;
  input.time = frame.time;
  input.odometry = frame.odometry;
  if (next_ == 0 && up_camera_) {
    input.up.emplace();
    input.up->up_base = up_camera_->normalized();
  }
  try {
    LiveInput::View view;
    view.camera = sequence_.camera;
    view.origin = frame.image_file;
    if (map_.usesImages()) view.image = readImage(frame.image_file, sequence_.camera);
    if (use_masks_ && !frame.mask_file.empty())
      view.mask = readImage(frame.mask_file, sequence_.camera, true);
    if (map_.usesDepth() && !frame.depth_file.empty()) {
      LiveInput::Depth depth;
      depth.image = {sequence_.camera, {}, sequence_.depth_scale, frame.depth_file, std::nullopt};
      depth.image.depth = readDepth(frame.depth_file, sequence_.camera);
      if (!view.mask.empty()) depth.image.mask = {view.mask, sequence_.camera, Pose::Identity()};
      input.depths.push_back(std::move(depth));
    }
    if (map_.usesImages()) input.views.push_back(std::move(view));
  } catch (const InputError& e) {
    *problem = e.what();
  }
  return input;
}

LiveResult SequenceLocalizer::step() {
  if (next_ >= sequence_.frames.size()) throw Error("no more images in the sequence");
  const SequenceFrame& frame = sequence_.frames[next_];
  std::string problem;
  const auto start = std::chrono::steady_clock::now();
  const LiveInput input = read(frame, &problem);
  reading_ms_ =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  ++next_;
  LiveResult result = localizer_.process(input);
  if (!problem.empty()) result.problem = problem;
  return result;
}

}  // namespace edge_mcl
