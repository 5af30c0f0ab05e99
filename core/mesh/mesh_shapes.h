/// Parts of a mesh that hang together: a cupboard, a door leaf, the shell of a building.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Two triangles that share an edge belong to one shape. Where three or more share an edge, bodies
/// touch one another, so it joins none. Shapes are numbered by their first triangle.
struct MeshShapes {
  std::vector<uint32_t> of_triangle;     ///< number of the shape of every triangle
  std::vector<Eigen::AlignedBox3f> box;  ///< of every shape, map frame, metres

  size_t count() const { return box.size(); }
};
MeshShapes findShapes(const MeshModel& mesh);

}  // namespace edge_mcl
