#include "edge_mcl/localization/recorded/sequence_input.h"

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

LiveInput readInput(const Sequence& sequence, const SequenceFrame& frame,
                    const SequenceParts& parts, std::string* problem) {
  LiveInput input;
  input.time = frame.time;
  input.time_text = frame.time_text;
  input.odometry = frame.odometry;
  LiveInput::CameraImage view;
  try {
    view.camera = sequence.camera;
    view.origin = frame.image_file;
    if (parts.images) view.image = readImage(frame.image_file, sequence.camera);
    if (parts.masks && !frame.mask_file.empty())
      view.mask = readMask(frame.mask_file, sequence.camera);
    if (parts.images) input.images.push_back(view);
  } catch (const InputError& e) {
    *problem = e.what();
    return input;  // without the mask the depth image cannot be trusted either
  }
  // The image stays usable when the depth image cannot be read.
  if (parts.depths && !frame.depth_file.empty()) try {
      LiveInput::Depth depth;
      depth.image = {sequence.camera, {}, sequence.depth_scale, frame.depth_file, std::nullopt};
      depth.image.depth = readDepth(frame.depth_file, sequence.camera);
      if (!view.mask.empty()) depth.image.mask = {view.mask, sequence.camera, Pose::Identity()};
      input.depths.push_back(std::move(depth));
    } catch (const InputError& e) {
      *problem = e.what();
    }
  return input;
}

PoseGaussian initialGaussian(const Sequence& sequence, double std_position, double std_angle) {
  PoseGaussian initial;
  initial.mean = startOf(sequence);
  initial.covariance.diagonal().head<3>().setConstant(std_position * std_position);
  initial.covariance.diagonal().tail<3>().setConstant(std_angle * std_angle);
  return initial;
}

SequenceInput::SequenceInput(Sequence sequence, const SequenceParts& parts)
    : sequence_(std::move(sequence)), parts_(parts) {
  if (sequence_.initial_pose)
    initial_ =
        initialGaussian(sequence_, sequence_.initial_std_position, sequence_.initial_std_angle);
  for (const SequenceFrame& frame : sequence_.frames)
    if (frame.ground_truth) truth_.push_back({frame.time, frame.time_text, *frame.ground_truth});
}

bool SequenceInput::next(LiveInput* input, std::string* problem) {
  problem->clear();
  if (next_ >= sequence_.frames.size()) return false;
  *input = readInput(sequence_, sequence_.frames[next_++], parts_, problem);
  return true;
}

}  // namespace edge_mcl
