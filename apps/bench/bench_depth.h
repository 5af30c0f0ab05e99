/// Times the depth likelihood.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Times how long the depth image of a frame takes to score poses. There are three ways, which take
/// turns: point by point in double precision, and as the filter does it on one thread and on all
/// threads. Making the points from the image is timed as well.
/// @param map must use depth.
/// @param poses T_map_camera.
/// @param repeats number of measurements, whose median is reported.
/// @param print true: the result is printed as text, too.
/// @return the result as JSON; times in ms.
/// @throws InputError when the frame has no depth image
nlohmann::json timeDepth(const LocalizationMap& map, const Sequence& sequence,
                         const SequenceFrame& frame, const std::vector<Pose>& poses, int repeats,
                         bool print);

}  // namespace edge_mcl
