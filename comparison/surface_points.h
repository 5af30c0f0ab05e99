/// A mesh as MRPT's built-in maps want it: points of its surfaces, a section through it.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Points on all triangles, `spacing` (m) apart at most.
std::vector<Eigen::Vector3f> surfacePoints(const MeshModel& mesh, double spacing);

/// Where the horizontal plane at `height` (map z, m) cuts the triangles: ends of straight pieces.
std::vector<std::pair<Eigen::Vector2f, Eigen::Vector2f>> sectionOf(const MeshModel& mesh,
                                                                   double height);

}  // namespace edge_mcl
