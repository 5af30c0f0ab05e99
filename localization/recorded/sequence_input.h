/// A sequence directory as input of the localizer. The base is the camera, T_map_base =
/// T_map_camera.
#pragma once

#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// What of a sequence is read.
struct SequenceParts {
  bool images = true, masks = true, depths = false;
};

/// One frame's files. What cannot be read is not in it, and said in `problem`.
LiveInput readInput(const Sequence& sequence, const SequenceFrame& frame,
                    const SequenceParts& parts, std::string* problem);

/// Around the sequence's initial pose. @param std_position, std_angle m and rad, per axis.
PoseGaussian initialGaussian(const Sequence& sequence, double std_position, double std_angle);

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
