/// Time of the depth likelihood.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Times the depth image of a frame against the poses: point by point in double precision, and as
/// the filter does it, on one thread and on all, taking turns.
/// @param map one that uses depth. @throws InputError when the frame has no depth image.
nlohmann::json timeDepth(const LocalizationMap& map, const Sequence& sequence,
                         const SequenceFrame& frame, const std::vector<Pose>& poses, int repeats,
                         bool print);

}  // namespace edge_mcl
