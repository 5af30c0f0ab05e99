/// The directions that a building's lines have: of its walls, mostly.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// Unit vectors, map frame, at most three, none within 30 degrees of another: those that most of
/// the length of the model's lines follows, to a few degrees. Those that hardly any line follows
/// (less than a twentieth of the first one's length) are left out.
std::vector<Eigen::Vector3d> mainDirections(const EdgeModel& model);

}  // namespace edge_mcl
