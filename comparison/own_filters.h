/// Runs edge_mcl's own localizer, and dead reckoning.
#pragma once

#include "edge_mcl/comparison/compared_filter.h"

namespace edge_mcl {

/// The complete localizer: mixture proposal, states and recovery.
class OwnFilter : public ComparedFilter {
 public:
  explicit OwnFilter(std::shared_ptr<const LocalizationMap> map);
  void initialize(const PoseGaussian& start) override { localizer_.setPose(start); }
  Pose process(const LiveInput& input, const Pose& truth) override;

 private:
  LiveLocalizer localizer_;
};

/// Moves the start pose by the odometry alone.
class DeadReckoning : public ComparedFilter {
 public:
  explicit DeadReckoning(const FilterParameters& params) : motion_(params) {}
  void initialize(const PoseGaussian& start) override { pose_ = start.mean; }
  Pose process(const LiveInput& input, const Pose& truth) override;

 private:
  MotionSource motion_;
  Pose pose_ = Pose::Identity();
};

}  // namespace edge_mcl
