/// A recording whose poses are in the coordinates of the model file.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// Gives the poses of another recording relative to the origin of the map frame.
class MovedInput : public RecordedInput {
 public:
  /// @param origin of the map frame in the coordinates of the recording's poses, metres.
  MovedInput(std::unique_ptr<RecordedInput> input, const Eigen::Vector3d& origin);

  size_t imageCount() const override { return input_->imageCount(); }
  const std::optional<PoseGaussian>& initialPose() const override { return initial_; }
  const Trajectory& truth() const override { return truth_; }
  std::string damage() const override { return input_->damage(); }
  std::vector<std::string> notes() const override { return input_->notes(); }
  bool next(LiveInput* input, std::string* problem) override {
    return input_->next(input, problem);
  }

 private:
  std::unique_ptr<RecordedInput> input_;
  std::optional<PoseGaussian> initial_;
  Trajectory truth_;
};

}  // namespace edge_mcl
