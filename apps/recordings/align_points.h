/// Aligns a model by points that are known in its file and in another system.
#pragma once

#include <string>

#include "edge_mcl/core/base/measurement_parameters.h"

namespace edge_mcl {

/// Prints the placement of the model, and how far each point is off.
/// @param file with a line `x y z  X Y Z` for each point; # begins a comment
/// @param params map.scale counts when the scale is kept; 0: 1
/// @param out YAML file to write; empty: none
/// @return exit code: incomplete when a point is far off
/// @throws InputError when the file cannot be used
int alignPoints(const std::string& file, const MapParameters& params, bool keep_scale,
                const std::string& out, bool json);

}  // namespace edge_mcl
