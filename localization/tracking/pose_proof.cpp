#include "edge_mcl/localization/tracking/pose_proof.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/search/pose_tolerances.h"

namespace edge_mcl {

namespace {

// The values below that name no other source were set on the simulated flights of docs/search.md,
// so that no wrong pose passed and right poses passed as soon as possible.

/// Lines in view that make a pose unlikely to fit by chance. A pose has six degrees of freedom, and
/// a line fixes at least one. A pose that may be anywhere in the model has more places to fit.
constexpr double kManyLines = 6, kManyLinesAnywhere = 15;
/// A surface that fits fixes three degrees of freedom. It does not count where the pose may be
/// anywhere: every bare wall fits there.
constexpr double kLinesOfSurface = 3;

/// Squared Mahalanobis distance from which a pose is elsewhere. Of six-dimensional Gaussian errors
/// (chi-square, 6 degrees of freedom) less than one in a million is beyond kFar and one in twenty
/// beyond kFarInDoubt, which counts after an image that did not fit and until the pose is proven.
constexpr double kFar = 40, kFarInDoubt = 12.6;

/// An image shows less than usual when its match ratio is below this share of the mean.
constexpr double kMuchLess = 0.8;
/// Weight of the newest image in that mean, which thus covers about the last five images.
constexpr double kNewest = 0.2;

/// Trusted poses are remembered at this spacing for this time, in seconds: a pose that slides along
/// a line moves by more than its covariance within a second.
constexpr double kSpacing = 0.25, kOldest = 1;

/// Images in a row that contradict the pose before proof is needed. One image may be a bad one.
constexpr int kDoubts = 2;
/// Time and images that prove a pose where much of the model is in view and nearly all of it fits.
/// At 30 Hz the time decides, with a slow camera the number.
constexpr double kLongEnough = 1;  // s
constexpr int kEnoughImages = 5;

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

void PoseProof::move(const Pose& step, const Vector6& sigma) {
  moveByVelocity(step, sigma, Vector6::Zero());
}

void PoseProof::moveByVelocity(const Pose& step, const Vector6& sigma, const Vector6& drift) {
  const auto move = [&](Anchor* anchor) {
    anchor->pose = moved(anchor->pose, step, sigma);
    anchor->drift = adjoint(step.inverse()) * anchor->drift;
    anchor->drift.diagonal() += drift;
  };
  if (expected_) move(&*expected_);
  for (Anchor& anchor : anchors_) move(&anchor);
}

bool PoseProof::isFarFrom(const Anchor& anchor, const PoseGaussian& estimate) const {
  constexpr PoseTolerance kFloor = kProofFloor;
  Matrix6 covariance = anchor.pose.covariance;
  covariance += anchor.drift * anchor.drift.transpose();
  covariance.diagonal().head<3>().array() += kFloor.position * kFloor.position;
  covariance.diagonal().tail<3>().array() += kFloor.angle * kFloor.angle;
  const Twist off = logSe3(anchor.pose.mean.inverse() * estimate.mean);
  return squaredMahalanobis(off, covariance) > (doubts_ > 0 || needed_ ? kFarInDoubt : kFar);
}

bool PoseProof::isElsewhere(const PoseGaussian& estimate) const {
  if (expected_ && isFarFrom(*expected_, estimate)) return true;
  // A pose that slides along the only line in view moves from one image to the next by less than
  // its covariance allows. So it is compared with older poses as well.
  return std::any_of(anchors_.begin(), anchors_.end(),
                     [&](const Anchor& anchor) { return isFarFrom(anchor, estimate); });
}

bool PoseProof::showsLess(const ImageVerdict& image) const {
  return image.lines > 0 && image.lines < kManyLines &&
         image.match_ratio < kMuchLess * usual_ratio_;
}

void PoseProof::trust(const ImageVerdict& image, const PoseGaussian& estimate) {
  if (image.lines > 0) {
    if (usual_ratio_ == 0) usual_ratio_ = image.match_ratio;
    usual_ratio_ += kNewest * (image.match_ratio - usual_ratio_);
  }
  expected_ = Anchor{image.time, estimate};
  if (anchors_.empty() || image.time >= anchors_.back().time + kSpacing)
    anchors_.push_back({image.time, estimate});
  while (anchors_.front().time < image.time - kOldest) anchors_.pop_front();
}

bool PoseProof::add(const ImageVerdict& image, const PoseGaussian& estimate) {
  if (!image.confirmed) {
    doubts_ += image.contradicts ? 1 : 0;
    needed_ = needed_ || doubts_ >= kDoubts;
    since_.reset();
    return false;
  }
  if (isElsewhere(estimate) || showsLess(image)) {
    needed_ = true;
    since_.reset();
    anchors_.clear();
    usual_ratio_ = 0;
    expected_ = Anchor{image.time, estimate};  // later poses are compared with this one
  }
  doubts_ = 0;
  if (!since_) {
    // Later images of the proof are compared with its first one. The pose before may be long ago.
    if (needed_) expected_ = Anchor{image.time, estimate};
    since_ = image.time;
    images_ = 0;
    ratios_ = lines_ = 0;
  }
  ++images_;
  ratios_ += image.match_ratio;
  lines_ += image.lines + (image.on_surface && image.lines > 0 && !anywhere_ ? kLinesOfSurface : 0);
  if (needed_) {
    // At a wrong place that looks alike, less of the model fits, and few lines fit in many places.
    // Where that is so at the right place too, the proof takes longer. The search has the same
    // rule.
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
