/// When the experiments call a pose right.
#pragma once

#include "edge_mcl/localization/search/pose_tolerances.h"

namespace edge_mcl {

/// The errors of a right pose are below these. `probability` in a status means the same.
constexpr PoseTolerance kRightPose{0.25, 5 * kDegree};

}  // namespace edge_mcl
