/// Makes many updates in a row and measures whether the memory grows.
#pragma once

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Resident memory of this process now, MB.
double residentMegabytes();
/// Largest resident memory of this process so far, MB.
double peakResidentMegabytes();

/// Makes `updates` updates with the first 20 images of the sequence, forwards and backwards in
/// turn. Prints the resident memory after every tenth of them.
/// @return growth of the memory from the first tenth to the end, MB.
/// @throws InputError when the sequence has fewer than two images
double soak(const LocalizationMap& map, const Sequence& sequence, size_t updates);

}  // namespace edge_mcl
