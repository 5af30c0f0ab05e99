/// Contrast of a pose with the poses beside it.
#pragma once

#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// Score per line of a pose minus the mean of poses beside it, in standard deviations of their
/// scores. A pose that fits by chance has about 4, a right pose 7 or more. It is 0 when the pose
/// sees no line. The poses beside it are the same for every call.
/// @param pose T_map_base
double contrastOf(const LocalizationMap& map, const std::vector<CameraView>& views,
                  const Pose& pose);

}  // namespace edge_mcl
