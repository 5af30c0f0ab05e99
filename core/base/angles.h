/// Units of angles.
#pragma once

namespace edge_mcl {

/// One degree in radians.
constexpr double kDegree = 3.14159265358979323846 / 180;

}  // namespace edge_mcl
