/// A sequence directory as input of the localizer. The base of the robot is the camera:
/// T_map_base = T_map_camera.
#pragma once

#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// The kinds of files of a sequence that are read.
struct SequenceParts {
  bool images = true, masks = true, depths = false;
};

/// Reads the files of one frame. Files that cannot be read are left out; without the image or its
/// mask all files of the frame are left out. @param problem set to one line about the files that
/// were left out, else not changed.
LiveInput readInput(const Sequence& sequence, const SequenceFrame& frame,
                    const SequenceParts& parts, std::string* problem);

/// A Gaussian around the sequence's initial pose, T_map_camera.
/// @param std_position, std_angle standard deviations per axis, metres and radians.
/// @throws InputError when the sequence has no initial pose.
PoseGaussian initialGaussian(const Sequence& sequence, double std_position, double std_angle);

/// Reads the frames of a sequence one after the other.
class SequenceInput : public RecordedInput {
 public:
  SequenceInput(Sequence sequence, const SequenceParts& parts);
  size_t imageCount() const override { return sequence_.frames.size(); }
  const std::optional<PoseGaussian>& initialPose() const override { return initial_; }
  const Trajectory& truth() const override { return truth_; }
  bool next(LiveInput* input, std::string* problem) override;

 private:
  Sequence sequence_;
  SequenceParts parts_;
  std::optional<PoseGaussian> initial_;
  Trajectory truth_;
  size_t next_ = 0;
};

}  // namespace edge_mcl
