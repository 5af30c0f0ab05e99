/// The part of the proposal that draws particles to the modes of the likelihood.
#pragma once

#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/mrpt_plugins/random_source.h"

namespace edge_mcl {

/// log of a Gaussian density on SE(3) at a pose, in the tangent space at its mean.
class GaussianDensity {
 public:
  explicit GaussianDensity(const PoseGaussian& gaussian);
  double log(const Pose& pose) const;
  Pose draw(RandomSource* random) const;
  const PoseGaussian& gaussian() const { return gaussian_; }

 private:
  PoseGaussian gaussian_;
  Pose inverse_mean_;
  Matrix6 factor_, inverse_factor_;  // lower Cholesky factor of the covariance
  double log_norm_;
};

/// Gaussians around refined poses, all with the same share.
class ModeProposal {
 public:
  /// Refines the best of the predicted particles, keeps distinct results of high posterior.
  /// @param scores log-likelihoods of `predicted`. @param predictive Gaussian of `predicted`.
  ModeProposal(const LocalizationMap& map, const std::vector<CameraView>& views,
               const std::vector<Pose>& predicted, const std::vector<PoseScore>& scores,
               const GaussianDensity& predictive, int starts);

  bool empty() const { return modes_.empty(); }
  size_t size() const { return modes_.size(); }
  const GaussianDensity& mode(size_t i) const { return modes_[i]; }
  /// log of the mixture density.
  double log(const Pose& pose) const;

 private:
  std::vector<GaussianDensity> modes_;
};

}  // namespace edge_mcl
