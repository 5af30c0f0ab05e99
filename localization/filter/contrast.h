/// Contrast of a pose with poses turned away from it.
#pragma once

#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// Score per line of a pose minus the mean of 64 poses that are turned by 4 to 10 degrees, in
/// standard deviations of their scores. A pose that fits by chance has about 4, a right pose 7 or
/// more. It is 0 when the pose sees no line. The turns are the same for every call.
/// @param pose T_map_base
double contrastOf(const LocalizationMap& map, const std::vector<CameraView>& views,
                  const Pose& pose);

}  // namespace edge_mcl
