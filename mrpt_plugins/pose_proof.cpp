#include "edge_mcl/mrpt_plugins/pose_proof.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/mrpt_plugins/motion_noise.h"

namespace edge_mcl {

PoseProof::PoseProof(const Parameters& params)
    : enough_ratio_(params.likelihood.cues == Cues::kDepth ? 0 : params.search.min_match_ratio) {}

void PoseProof::begin(bool needed) {
  needed_ = needed;
  expected_.reset();
  since_.reset();
  doubts_ = 0;
}

void PoseProof::move(const Pose& step, const Twist& sigma) {
  if (expected_) expected_ = moved(*expected_, step, sigma);
}

bool PoseProof::isElsewhere(const PoseGaussian& estimate) const {
  // Poses are somewhat worse than their covariances say, odometry than its noise.
  constexpr double kPosition = 0.05, kAngle = M_PI / 180;
  // Of six dimensions less than one in a million is beyond the first; after an image that did not
  // fit one in twenty is suspect.
  constexpr double kFar = 40, kFarInDoubt = 12.6;
  if (!expected_) return false;
  Matrix6 covariance = expected_->covariance;
  covariance.diagonal().head<3>().array() += kPosition * kPosition;
  covariance.diagonal().tail<3>().array() += kAngle * kAngle;
  const Twist off = logSe3(expected_->mean.inverse() * estimate.mean);
  return off.dot(covariance.ldlt().solve(off)) > (doubts_ > 0 ? kFarInDoubt : kFar);
}

bool PoseProof::weigh(const ImageVerdict& image, const PoseGaussian& estimate) {
  constexpr int kDoubts = 3;         // images that spoke against the pose
  constexpr double kLongEnough = 1;  // s, where much of the model is in view and nearly all is seen
  constexpr int kEnoughImages = 5;
  constexpr double kManyLines = 6;
  if (!image.confirmed) {
    doubts_ += image.used ? 1 : 0;
    needed_ = needed_ || doubts_ >= kDoubts;
    since_.reset();
    return false;
  }
  if (isElsewhere(estimate)) {
    needed_ = true;
    since_.reset();
    expected_ = estimate;  // from here on it must stay there
  }
  doubts_ = 0;
  if (!since_) {
    since_ = image.time;
    images_ = 0;
    ratios_ = lines_ = 0;
  }
  ++images_;
  ratios_ += image.match_ratio;
  lines_ += image.lines;
  if (needed_) {
    // At a place that looks alike less of the model is seen, and few lines fit in many places.
    // Where that is so at the right place too, it takes longer; as in the search.
    double enough = kLongEnough;
    if (enough_ratio_ > 0)
      enough *= std::pow(std::max(1.0, enough_ratio_ / std::max(ratios_ / images_, 0.01)), 2);
    if (lines_ > 0) enough *= std::max(1.0, kManyLines * images_ / lines_);
    needed_ = image.time - *since_ < enough || images_ < kEnoughImages;
  }
  if (!needed_) expected_ = estimate;
  return !needed_;
}

}  // namespace edge_mcl
