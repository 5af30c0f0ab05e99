/// The part of the filter's proposal density that draws particles at the modes of the likelihood.
#pragma once

#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// A Gaussian density on SE(3), in the tangent space at its mean (`mean * exp(xi)`). All results
/// are natural logarithms.
class GaussianDensity {
 public:
  /// Adds (0.1 mm)^2 and (0.003 degrees)^2 to the variances, so that the covariance can be
  /// inverted.
  explicit GaussianDensity(const PoseGaussian& gaussian);
  /// Log density at a pose.
  double log(const Pose& pose) const { return logOfOffset(offset(pose)); }
  /// The pose as a tangent vector at the mean: metres, radians.
  Twist offset(const Pose& pose) const { return logSe3(inverse_mean_ * pose); }
  /// Log density at a tangent vector from offset().
  double logOfOffset(const Twist& offset) const;
  /// Draws a random pose.
  Pose draw(RandomSource* random) const {
    return normalized(gaussian_.mean * expSe3(drawOffset(random)));
  }
  /// Draws a random tangent vector at the mean.
  Twist drawOffset(RandomSource* random) const { return factor_ * random->normalTwist(); }
  /// Mean and covariance, with the addition that the constructor makes.
  const PoseGaussian& gaussian() const { return gaussian_; }

 private:
  PoseGaussian gaussian_;
  Pose inverse_mean_;
  Matrix6 factor_, inverse_factor_;  // lower Cholesky factor of the covariance, and its inverse
  double log_norm_;
};

/// The predictive density with heavy tails: a mixture of two Gaussians with the same mean. The core
/// is fitted to the predicted particles. The tail is wider and has a small share.
class PredictiveDensity {
 public:
  /// @param cloud Gaussian of the predicted particles, T_map_base: the core.
  /// @param tail_share share of the tail in the mixture, in [0, 1).
  /// @param extra covariance of the tail minus covariance of the core.
  PredictiveDensity(const PoseGaussian& cloud, double tail_share, const Matrix6& extra);
  /// Log density of the mixture at a pose.
  double log(const Pose& pose) const;
  /// Draws a random pose from the tail.
  Pose drawTail(RandomSource* random) const { return tail_.draw(random); }
  const PoseGaussian& core() const { return core_.gaussian(); }
  /// The component (core or tail) that the pose more likely comes from. It is the prior when this
  /// pose is refined.
  const PoseGaussian& componentOf(const Pose& pose) const;

 private:
  GaussianDensity core_, tail_;
  double log_core_share_, log_tail_share_;
};

/// A mixture of Gaussians around refined poses (modes). All modes have the same share.
class ModeProposal {
 public:
  /// Refines the mean of the predictive density and the best predicted particles, and keeps the
  /// distinct results of high posterior as modes. A result needs six or more matched samples and
  /// depth points. There may be no mode at all.
  /// @param predicted particles, T_map_base. @param scores of `predicted`, in the same order.
  /// @param predictive density of `predicted`: prior of the refinement and of the posterior.
  /// @param starts largest number of poses that are refined.
  ModeProposal(const LocalizationMap& map, const std::vector<CameraView>& views,
               const std::vector<Pose>& predicted, const std::vector<PoseScore>& scores,
               const PredictiveDensity& predictive, int starts);

  bool empty() const { return modes_.empty(); }
  size_t size() const { return modes_.size(); }
  const GaussianDensity& mode(size_t i) const { return modes_[i]; }
  /// Log density of the mixture at a pose. There must be a mode.
  double log(const Pose& pose) const;

 private:
  std::vector<GaussianDensity> modes_;
};

}  // namespace edge_mcl
