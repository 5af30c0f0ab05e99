/// Rectangles that lie within the flat parts of a mesh.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Corners in order, map frame, metres.
using Rectangle = std::array<Eigen::Vector3d, 4>;

/// Triangles whose corners are farther from the common plane are left out, m.
constexpr double kFlat = 2e-4;

/// Finds large rectangles that the triangles of a mesh cover without a gap: walls beside and above
/// a door, floors, table tops. It does not matter into how many triangles a wall is divided. Their
/// borders are up to a decimetre inside of those of the wall, where these do not lie along its
/// longest edge.
/// @param least area of the smallest rectangle, m^2
std::vector<Rectangle> flatRectangles(const MeshModel& mesh, double least);

}  // namespace edge_mcl
