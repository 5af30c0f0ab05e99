/// Cost of a hypothesis that jumps against odometry.
#pragma once

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Nats by which a pose is less likely than the mean of what odometry expects: the logarithm of the
/// ratio of Student's t densities with 4 degrees of freedom. Its tails are heavy, since a wheel
/// that slips must not cost the true hypothesis the search.
/// @param expected covariance in the tangent space at its mean
double jumpCost(const PoseGaussian& expected, const Pose& found);

}  // namespace edge_mcl
