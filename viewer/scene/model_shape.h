/// The model as triangles and lines to draw, with all that is above a height left out: one looks
/// into a building from above.
#pragma once

#include <array>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

struct ModelShape {
  struct Triangle {
    std::array<Eigen::Vector3f, 3> corners;
    Eigen::Vector3f color;  ///< red, green, blue, 0 to 1; shaded
  };
  std::vector<Triangle> triangles;
  std::vector<std::array<Eigen::Vector3f, 2>> lines;  ///< feature edges, without contours
};

/// What is below `height` (map, m); triangles and lines that reach above it are cut there.
ModelShape shapeBelow(const MeshModel& mesh, const EdgeModel& edges, float height);

/// Where a ray first meets the shape. @return false: nowhere. @param direction of any length.
bool firstHit(const ModelShape& shape, const Eigen::Vector3f& origin,
              const Eigen::Vector3f& direction, Eigen::Vector3f* hit);

}  // namespace edge_mcl
