/// Cuts the model at a height, so that one can look into a building from above.
#pragma once

#include <array>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Triangles and lines to draw, map frame, m.
struct ModelShape {
  struct Triangle {
    std::array<Eigen::Vector3f, 3> corners;
    Eigen::Vector3f color;  ///< red, green, blue, 0 to 1; already shaded
  };
  std::vector<Triangle> triangles;
  std::vector<std::array<Eigen::Vector3f, 2>> lines;  ///< feature edges, without contours
};

/// Returns the part of the model below `height` (map, m). Triangles and lines that reach above the
/// height are cut.
ModelShape shapeBelow(const MeshModel& mesh, const EdgeModel& edges, float height);

/// Finds the first point where a ray meets the shape. @param origin map, m. @param direction map
/// axes, of any length. @param hit map, m. @return false when the ray meets nothing.
bool firstHit(const ModelShape& shape, const Eigen::Vector3f& origin,
              const Eigen::Vector3f& direction, Eigen::Vector3f* hit);

}  // namespace edge_mcl
