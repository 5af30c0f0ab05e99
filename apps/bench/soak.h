/// Many updates in a row: does memory grow?
#pragma once

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Megabytes of memory of this process: resident now, and at most so far.
double residentMegabytes();
double peakResidentMegabytes();

/// Runs that many updates on the first images of the sequence, forth and back, and prints the
/// resident size along the way. @return megabytes gained between the first tenth and the end.
double soak(const LocalizationMap& map, const Sequence& sequence, size_t updates);

}  // namespace edge_mcl
