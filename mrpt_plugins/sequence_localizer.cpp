#include "edge_mcl/mrpt_plugins/sequence_localizer.h"

#include <chrono>

#include "edge_mcl/core/error.h"

namespace edge_mcl {

SequenceLocalizer::SequenceLocalizer(const LocalizationMap& map, const Sequence& sequence,
                                     bool use_masks)
    : map_(map),
      sequence_(sequence),
      use_masks_(use_masks),
      filter_(map.params().filter, map.params().refinement) {
  setInitialSpread(sequence.initial_std_position, sequence.initial_std_angle);
}

void SequenceLocalizer::setInitialSpread(double std_position, double std_angle) {
  filter_.initialize(sequence_.initial_pose, std_position, std_angle);
}

void SequenceLocalizer::predict(const SequenceFrame& frame) {
  if (next_ == 0) return;
  const SequenceFrame& last = sequence_.frames[next_ - 1];
  const double dt = frame.time - last.time;
  if (frame.odometry && last.odometry)
    filter_.predictWithOdometry(normalized(last.odometry->inverse() * *frame.odometry), dt);
  else
    filter_.predictWithoutOdometry(dt);
}

FrameResult SequenceLocalizer::step() {
  if (next_ >= sequence_.frames.size()) throw Error("no more images in the sequence");
  const SequenceFrame& frame = sequence_.frames[next_];
  FrameResult result;
  predict(frame);
  ++next_;
  try {
    const auto start = std::chrono::steady_clock::now();
    cv::Mat image, mask;
    DepthImage depth{sequence_.camera, {}, sequence_.depth_scale, frame.depth_file, std::nullopt};
    if (map_.usesImages()) image = readImage(frame.image_file, sequence_.camera);
    if (use_masks_ && !frame.mask_file.empty())
      mask = readImage(frame.mask_file, sequence_.camera, true);
    if (map_.usesDepth() && !frame.depth_file.empty())
      depth.depth = readDepth(frame.depth_file, sequence_.camera);
    result.reading_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    CameraView view;
    if (!image.empty()) {
      result.image = map_.prepare(sequence_.camera, image, mask, frame.image_file);
      result.image_times = result.image->times;
      view.image = result.image;
    }
    if (!depth.depth.empty()) {
      if (!mask.empty()) depth.mask = {mask, sequence_.camera, Pose::Identity()};
      view.depth = map_.prepareDepth(depth);
    }
    if (view.image || view.depth) {
      result.report = filter_.update(map_, {view});
      result.updated = true;
      if (!result.report.has_information)
        result.problem = frame.image_file + ": nothing of the model in view, pose predicted";
    }
  } catch (const InputError& e) {
    result.problem = e.what();
  }
  result.estimate = filter_.estimate();
  return result;
}

}  // namespace edge_mcl
