/// Depth points against the model's surfaces: likelihood of many poses, and its derivative.
///
/// A beam-end model (S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", section 6.4): a point
/// is on the model with Gaussian noise, or clutter anywhere within the truncation. As in the robust
/// edge likelihood the score is a log-ratio, here against clutter alone:
///   log(c + (1 - c) T sqrt(2/pi) / sigma exp(-d^2 / (2 sigma^2))),
/// d the distance from the nearest surface, T the truncation, c the share of clutter. A pixel
/// without return scores 0 at every pose: what blinds a depth camera is not in the model. The mean
/// over the pixels counts as `depth.independent_points` independent ones.
#pragma once

#include <memory>
#include <vector>

#include "edge_mcl/core/base/normal_equations.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/depth/depth_points.h"
#include "edge_mcl/core/depth/distance_field.h"

namespace edge_mcl {

/// What a depth image says of one pose.
struct DepthScore {
  double log_likelihood = 0;
  float agreement = 0;  ///< mean probability of a point to be on the model
};

class DepthLikelihood {
 public:
  DepthLikelihood(std::shared_ptr<const DistanceField> field, const DepthParameters& params);

  const DistanceField& field() const { return *field_; }

  /// @param camera_poses T_map_depth. A pose alone gives the same bits as in a batch, whatever the
  /// number of threads. @throws Error when a pose is not finite.
  std::vector<DepthScore> evaluate(const DepthPoints& points,
                                   const std::vector<Pose>& camera_poses) const;

  /// The same in double precision, point by point: what evaluate is tested against.
  DepthScore evaluateSlowly(const DepthPoints& points, const Pose& camera_pose) const;

  /// Point-to-surface distances around T_map_depth, for T_map_depth * exp(xi).
  /// @param least_sigma m; smaller noise counts as this, so that far points pull while a refinement
  /// begins.
  /// A bias common to all points (DepthPoints::bias_variance) is marginalised.
  NormalEquations linearize(const DepthPoints& points, const Pose& camera_pose,
                            double least_sigma) const;

  /// What is left of the bias, seen from a pose.
  /// @param points as withoutBias gives them. @param camera_covariance of the pose, tangent space.
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
