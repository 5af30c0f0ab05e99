/// The main directions of a model's lines, mostly the directions of its walls.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// Finds the directions that have the most line length parallel to them, within 3 degrees. Contours
/// do not count. Directions with at most a twentieth of the length of the first one are left out.
/// @return at most three unit vectors, map frame, none within 30 degrees of another.
std::vector<Eigen::Vector3d> mainDirections(const EdgeModel& model);

}  // namespace edge_mcl
