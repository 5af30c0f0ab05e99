/// How near two poses must be to count as one, and how uncertain a pose is at least.
///
/// All values are metres and radians. They were set on simulated flights through office, house and
/// hall (docs/search.md); each relation that must hold between them is stated.
#pragma once

#include <cmath>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

struct PoseTolerance {
  double position;  ///< m
  double angle;     ///< rad
};

/// Whether a standard deviation of the pose is above the tolerance, along any axis.
inline bool isWiderThan(const PoseTolerance& tolerance, const PoseGaussian& pose) {
  const Vector6 variance = pose.covariance.diagonal();
  return std::sqrt(variance.head<3>().maxCoeff()) > tolerance.position ||
         std::sqrt(variance.tail<3>().maxCoeff()) > tolerance.angle;
}

/// Adds independent errors with these standard deviations to a pose.
inline void addVariance(const PoseTolerance& sigma, PoseGaussian* pose) {
  pose->covariance.diagonal().head<3>().array() += sigma.position * sigma.position;
  pose->covariance.diagonal().tail<3>().array() += sigma.angle * sigma.angle;
}

/// Smallest standard deviation of a pose that the search reports. Along a bare wall a pose may
/// explain everything that is seen and still have this error.
constexpr PoseTolerance kSearchFloor{0.05, 1.5 * kDegree};
/// Smallest standard deviation of a refined pose from which the next keyframe is predicted. The
/// refinement of one hypothesis repeats within this.
constexpr PoseTolerance kFollowFloor{0.02, 0.5 * kDegree};
/// Added to the standard deviation of a trusted pose before a new pose is compared with it, since
/// covariances are somewhat too small.
constexpr PoseTolerance kProofFloor{0.05, kDegree};

/// Two estimates this near are one pose: twice kSearchFloor. It is also the accuracy that tables
/// in the documents call right.
constexpr PoseTolerance kSamePose{0.1, 3 * kDegree};
/// Two hypotheses this near have come together and are merged: less than kSamePose, so that those
/// which a new look may tell apart are kept.
constexpr PoseTolerance kMergedHypothesis{0.08, 2 * kDegree};
/// A pose farther away than this is another one for the margin between neighbours. Shelves and
/// steps repeat at somewhat more than this distance. It is more than kSamePose.
constexpr PoseTolerance kNeighbour{0.12, 3 * kDegree};
/// Hypotheses this near are one place in reports: a little more than `search.place_spacing`.
constexpr PoseTolerance kSamePlace{0.5, 15 * kDegree};

/// A standard deviation above this is wide: the filter may settle on another line, since the
/// normals reach less far. It equals `filter.recovery_std_*`, to two digits.
constexpr PoseTolerance kWideSpread{0.3, 0.14};

}  // namespace edge_mcl
