/// Triangles of a polygon that is not convex.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace edge_mcl {

/// Whether it turns the same way at every corner, and at none goes (nearly) straight on, as where
/// another wall begins.
bool isStrictlyConvex(const std::vector<Eigen::Vector3d>& corners);

/// Cuts off the fattest ear again and again (G. Meisters, "Polygons have ears", 1975), so that
/// every corner stays a corner of triangles that have an area: no triangle is flat, none has a
/// corner on its side.
/// @param corners of a flat polygon, in order, any units.
/// @return numbers of corners, turning as the polygon does; empty where it is not flat, has more
/// than 300 corners, or no ear is found (it crosses itself).
std::vector<std::array<unsigned, 3>> cutEars(const std::vector<Eigen::Vector3d>& corners);

}  // namespace edge_mcl
