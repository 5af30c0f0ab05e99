/// Converts a mesh for MRPT's built-in maps: points on its surfaces, and a section through it.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Puts points (map, m) on all triangles. Neighbouring points are at most `spacing` (m) apart.
std::vector<Eigen::Vector3f> surfacePoints(const MeshModel& mesh, double spacing);

/// Cuts the triangles with the horizontal plane at `height` (map z, m). @return ends of the
/// straight pieces of the section, map x and y, m.
std::vector<std::pair<Eigen::Vector2f, Eigen::Vector2f>> sectionOf(const MeshModel& mesh,
                                                                   double height);

}  // namespace edge_mcl
