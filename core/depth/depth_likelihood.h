/// Likelihood of poses from depth points and the model's surfaces, and its derivative.
///
/// This is a beam-end model (S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", section 6.4).
/// A point is on the model with Gaussian noise, or it is clutter anywhere within the truncation. As
/// in the robust edge likelihood the score is a log-ratio, here against clutter alone:
///   log(c + (1 - c) T sqrt(2/pi) / sigma exp(-d^2 / (2 sigma^2))),
/// with d the distance from the nearest surface, T the truncation and c the share of clutter. A
/// pixel without return scores 0 at every pose, because things that blind a depth camera are not in
/// the model. The mean over the pixels counts as `depth.independent_points` independent points.
#pragma once

#include <memory>
#include <vector>

#include "edge_mcl/core/base/normal_equations.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/depth/depth_points.h"
#include "edge_mcl/core/depth/distance_field.h"

namespace edge_mcl {

/// Score of one pose with one depth image.
struct DepthScore {
  double log_likelihood = 0;
  float agreement = 0;  ///< mean probability that a point is on the model
};

/// Scores poses with depth points, and linearizes the distances of the points for a refinement.
class DepthLikelihood {
 public:
  DepthLikelihood(std::shared_ptr<const DistanceField> field, const DepthParameters& params);

  const DistanceField& field() const { return *field_; }

  /// Scores poses. A pose alone gets the same bits as in a batch, for any number of threads.
  /// @param camera_poses T_map_depth.
  /// @throws Error when a pose is not valid, see isValid().
  std::vector<DepthScore> evaluate(const DepthPoints& points,
                                   const std::vector<Pose>& camera_poses) const;

  /// Scores a pose in double precision, point by point. Tests compare evaluate() with it.
  DepthScore evaluateSlowly(const DepthPoints& points, const Pose& camera_pose) const;

  /// Normal equations of the point-to-surface distances around T_map_depth, for
  /// T_map_depth * exp(xi). A bias that all points share (DepthPoints::bias_variance) is
  /// marginalised.
  /// @param camera_pose T_map_depth.
  /// @param least_sigma m; smaller noise counts as this value, so that points far from the surface
  ///   pull at the start of a refinement.
  NormalEquations linearize(const DepthPoints& points, const Pose& camera_pose,
                            double least_sigma) const;

  /// Estimates the bias that remains in the points, given a pose. It is 0 without
  /// DepthPoints::bias_variance.
  /// @param points from withoutBias().
  /// @param camera_pose T_map_depth.
  /// @param camera_covariance covariance of the pose in its tangent space.
  DepthBias remainingBias(const DepthPoints& points, const Pose& camera_pose,
                          const Matrix6& camera_covariance) const;

 private:
  struct WithBias;
  WithBias linearizeWithBias(const DepthPoints& points, const Pose& camera_pose,
                             double least_sigma) const;
  double weightOf(const DepthPoints& points) const;
  std::shared_ptr<const DistanceField> field_;
  DepthParameters params_;
};

}  // namespace edge_mcl
