/// Normal equations of a Gauss-Newton step.
#pragma once

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Normal equations h xi = g, as sums over edge samples and depth points. Matched and used ones are
/// counted separately.
struct NormalEquations {
  Matrix6 h = Matrix6::Zero();
  Twist g = Twist::Zero();
  int matched = 0, used = 0;                ///< number of edge samples
  int matched_points = 0, used_points = 0;  ///< number of depth points

  NormalEquations& operator+=(const NormalEquations& other) {
    h += other.h;
    g += other.g;
    matched += other.matched;
    used += other.used;
    matched_points += other.matched_points;
    used_points += other.used_points;
    return *this;
  }
};

}  // namespace edge_mcl
