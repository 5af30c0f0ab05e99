/// The part of the proposal that draws particles to the modes of the likelihood.
#pragma once

#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// log of a Gaussian density on SE(3) at a pose, in the tangent space at its mean.
class GaussianDensity {
 public:
  explicit GaussianDensity(const PoseGaussian& gaussian);
  double log(const Pose& pose) const { return logOfOffset(offset(pose)); }
  /// The pose in the tangent space at the mean, and the log density there.
  Twist offset(const Pose& pose) const { return logSe3(inverse_mean_ * pose); }
  double logOfOffset(const Twist& offset) const;
  Pose draw(RandomSource* random) const;
  const PoseGaussian& gaussian() const { return gaussian_; }

 private:
  PoseGaussian gaussian_;
  Pose inverse_mean_;
  Matrix6 factor_, inverse_factor_;  // lower Cholesky factor of the covariance
  double log_norm_;
};

/// Predictive density with heavy tails: a Gaussian fitted to the predicted particles and, with a
/// small share, one whose covariance is larger by `extra`.
class PredictiveDensity {
 public:
  PredictiveDensity(const PoseGaussian& cloud, double tail_share, const Matrix6& extra);
  double log(const Pose& pose) const;
  Pose drawTail(RandomSource* random) const { return tail_.draw(random); }
  const PoseGaussian& core() const { return core_.gaussian(); }
  /// The component that a pose more likely stems from: the prior for refining it.
  const PoseGaussian& componentOf(const Pose& pose) const;

 private:
  GaussianDensity core_, tail_;
  double log_core_share_, log_tail_share_;
};

/// Gaussians around refined poses, all with the same share.
class ModeProposal {
 public:
  /// Refines the best of the predicted particles, keeps distinct results of high posterior.
  /// @param scores log-likelihoods of `predicted`. @param predictive Gaussian of `predicted`.
  ModeProposal(const LocalizationMap& map, const std::vector<CameraView>& views,
               const std::vector<Pose>& predicted, const std::vector<PoseScore>& scores,
               const PredictiveDensity& predictive, int starts);

  bool empty() const { return modes_.empty(); }
  size_t size() const { return modes_.size(); }
  const GaussianDensity& mode(size_t i) const { return modes_[i]; }
  /// log of the mixture density.
  double log(const Pose& pose) const;

 private:
  std::vector<GaussianDensity> modes_;
};

}  // namespace edge_mcl
