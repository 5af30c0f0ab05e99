/// Where a model file lies in another system, as parameters and as text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "edge_mcl/core/base/measurement_parameters.h"
#include "edge_mcl/core/recordings/similarity_fit.h"

namespace edge_mcl {

/// The placement of the model file in the other system.
struct Placement {
  MapParameters map;  ///< scale, position and angles
  Similarity whole;   ///< from the file to the other system
};

/// @param used parameters with which the map was made. @param scale of these, metres per unit of
/// the file. @param s from the map to the other system.
Placement placementOf(const MapParameters& used, double scale, const Similarity& s);

/// The parameters with their standard deviations, for --json. @param position_sigma m
/// @param rotation_sigma rad
nlohmann::json jsonOf(const Placement& placement, double position_sigma, double rotation_sigma,
                      double scale_sigma);

/// The parameters map.*, for --params.
std::string yamlOf(const Placement& placement);

/// The command of a static transform from the other system to a model in metres, with the end of
/// the line. Empty when the scale is another one, since a transform has no scale.
/// @param scale metres per unit of the file
std::string transformLine(const Placement& placement, double scale);

}  // namespace edge_mcl
