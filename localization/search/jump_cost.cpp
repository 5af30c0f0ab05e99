#include "edge_mcl/localization/search/jump_cost.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace edge_mcl {

double jumpCost(const PoseGaussian& expected, const Pose& found) {
  constexpr double kDegrees = 4, kDimensions = 6;
  const Twist offset = logSe3(expected.mean.inverse() * found);
  const double squared = offset.dot(expected.covariance.ldlt().solve(offset));
  return 0.5 * (kDegrees + kDimensions) * std::log1p(std::max(0.0, squared) / kDegrees);
}

}  // namespace edge_mcl
