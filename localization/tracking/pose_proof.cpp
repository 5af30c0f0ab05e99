#include "edge_mcl/localization/tracking/pose_proof.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/localization/filter/motion_noise.h"

namespace edge_mcl {

namespace {

// In view, for a pose that is about known, and for one that may be anywhere.
constexpr double kManyLines = 6, kManyLinesAnywhere = 15;

}  // namespace

PoseProof::PoseProof(const Parameters& params)
    : enough_ratio_(params.likelihood.cues == Cues::kDepth ? 0 : params.search.min_match_ratio) {}

void PoseProof::begin(bool needed) {
  needed_ = needed;
  anywhere_ = false;
  expected_.reset();
  anchors_.clear();
  usual_ratio_ = 0;
  since_.reset();
  doubts_ = 0;
}

void PoseProof::move(const Pose& step, const Twist& sigma) {
  if (expected_) expected_ = moved(*expected_, step, sigma);
  for (Anchor& anchor : anchors_) anchor.pose = moved(anchor.pose, step, sigma);
}

bool PoseProof::isFarFrom(const PoseGaussian& expected, const PoseGaussian& estimate) const {
  // Poses are somewhat worse than their covariances say, odometry than its noise.
  constexpr double kPosition = 0.05, kAngle = M_PI / 180;
  // Of six dimensions less than one in a million is beyond the first; after an image that did not
  // fit, and until the pose is proven, one in twenty is suspect.
  constexpr double kFar = 40, kFarInDoubt = 12.6;
  Matrix6 covariance = expected.covariance;
  covariance.diagonal().head<3>().array() += kPosition * kPosition;
  covariance.diagonal().tail<3>().array() += kAngle * kAngle;
  const Twist off = logSe3(expected.mean.inverse() * estimate.mean);
  return off.dot(covariance.ldlt().solve(off)) > (doubts_ > 0 || needed_ ? kFarInDoubt : kFar);
}

bool PoseProof::isElsewhere(const PoseGaussian& estimate) const {
  if (expected_ && isFarFrom(*expected_, estimate)) return true;
  // A pose that slides along the only line in view goes no farther from one image to the next than
  // its covariance allows.
  return std::any_of(anchors_.begin(), anchors_.end(),
                     [&](const Anchor& anchor) { return isFarFrom(anchor.pose, estimate); });
}

bool PoseProof::showsLess(const ImageVerdict& image) const {
  constexpr double kMuchLess = 0.8;
  return image.lines > 0 && image.lines < kManyLines &&
         image.match_ratio < kMuchLess * usual_ratio_;
}

void PoseProof::trust(const ImageVerdict& image, const PoseGaussian& estimate) {
  constexpr double kSpacing = 0.25, kOldest = 1;  // s
  constexpr double kNewest = 0.2;                 // weight in the mean
  if (image.lines > 0) {
    if (usual_ratio_ == 0) usual_ratio_ = image.match_ratio;
    usual_ratio_ += kNewest * (image.match_ratio - usual_ratio_);
  }
  expected_ = estimate;
  if (anchors_.empty() || image.time >= anchors_.back().time + kSpacing)
    anchors_.push_back({image.time, estimate});
  while (anchors_.front().time < image.time - kOldest) anchors_.pop_front();
}

bool PoseProof::weigh(const ImageVerdict& image, const PoseGaussian& estimate) {
  constexpr int kDoubts = 2;         // images that spoke against the pose
  constexpr double kLongEnough = 1;  // s, where much of the model is in view and nearly all is seen
  constexpr int kEnoughImages = 5;
  if (!image.confirmed) {
    doubts_ += image.used ? 1 : 0;
    needed_ = needed_ || doubts_ >= kDoubts;
    since_.reset();
    return false;
  }
  if (isElsewhere(estimate) || showsLess(image)) {
    needed_ = true;
    since_.reset();
    anchors_.clear();
    usual_ratio_ = 0;
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
    if (lines_ > 0) {
      const double few = (anywhere_ ? kManyLinesAnywhere : kManyLines) * images_ / lines_;
      enough *= std::pow(std::max(1.0, few), anywhere_ ? 2 : 1);
    }
    needed_ = image.time - *since_ < enough || images_ < kEnoughImages;
  }
  if (!needed_) {
    anywhere_ = false;
    trust(image, estimate);
  }
  return !needed_;
}

}  // namespace edge_mcl
