/// Triangulation of polygons that are not convex.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace edge_mcl {

/// Whether a polygon turns the same way at every corner. It is not strictly convex if it goes
/// (nearly) straight on at a corner, e.g. where another wall begins.
bool isStrictlyConvex(const std::vector<Eigen::Vector3d>& corners);

/// Cuts a flat polygon into triangles. It cuts off the fattest ear again and again (G. Meisters,
/// "Polygons have ears", 1975). Every corner stays a corner of triangles that have an area: no
/// triangle is flat, and no triangle has a corner on its side.
/// @param corners of a flat polygon, in order, any unit.
/// @return numbers of corners, with the winding of the polygon. Empty when the polygon is not flat,
///   has fewer than 3 or more than 300 corners, or has no ear (it crosses itself).
std::vector<std::array<unsigned, 3>> cutEars(const std::vector<Eigen::Vector3d>& corners);

}  // namespace edge_mcl
