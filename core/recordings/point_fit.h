/// Finds how two systems of coordinates lie to each other, from points that are known in both.
#pragma once

#include <optional>
#include <vector>

#include "edge_mcl/core/recordings/similarity_fit.h"

namespace edge_mcl {

/// One point in both systems, e.g. a corner that was clicked in a model and in another map.
struct PointPair {
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
};

struct PointFit {
  Similarity similarity;
  std::vector<double> residuals;  ///< distance of each pair from the similarity, in units of `to`
  double rms = 0;                 ///< of the residuals
  /// Standard deviations by the residuals: of the shift in the middle of the points, of the worst
  /// rotation, rad, and of the scale. 0 when three points leave nothing over.
  double position_sigma = 0, rotation_sigma = 0, scale_sigma = 0;
};

/// Fits a similarity by least squares (S. Umeyama, "Least-squares estimation of transformation
/// parameters between two point patterns", 1991). Points of a plan may lie in a plane.
/// @param scale units of `to` for each unit of `from`; none: it is fitted
/// @throws InputError when there are fewer than three pairs, when a number is not finite, or when
/// the points lie on a line
PointFit fitPoints(const std::vector<PointPair>& pairs, std::optional<double> scale);

}  // namespace edge_mcl
