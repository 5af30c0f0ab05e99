/// Coarser faces of a scan.
#pragma once

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Joins all vertices in a cube to their mean (J. Rossignac, P. Borrel, "Multi-resolution 3D
/// approximations for rendering complex scenes", 1993). Faces within one cube vanish, and of equal
/// faces one stays. A surface moves by less than the size of a cube.
/// @param size of the cubes, m.
MeshSoup simplifiedFaces(const std::vector<Eigen::Vector3f>& vertices,
                         const std::vector<std::array<uint32_t, 3>>& triangles, double size);

}  // namespace edge_mcl
