#include "edge_mcl/localization/recorded/moved_input.h"

#include <utility>

namespace edge_mcl {

MovedInput::MovedInput(std::unique_ptr<RecordedInput> input, const Eigen::Vector3d& origin)
    : input_(std::move(input)), initial_(input_->initialPose()), truth_(input_->truth()) {
  if (initial_) initial_->mean.translation() -= origin;
  for (StampedPose& p : truth_) p.pose.translation() -= origin;
}

}  // namespace edge_mcl
