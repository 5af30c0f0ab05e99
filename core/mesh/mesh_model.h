/// Triangle mesh and line elements of a building or an object, as read from a file.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// What was found and mended while a mesh was read.
struct MeshReport {
  size_t vertices_read = 0;         ///< before welding
  size_t degenerate_triangles = 0;  ///< dropped: no area
  size_t duplicate_triangles = 0;   ///< dropped: same three vertices
  size_t zero_length_lines = 0;     ///< dropped
  size_t flipped_pairs = 0;         ///< neighbouring triangles wound against each other
  size_t boundary_edges = 0;        ///< edges with one triangle (holes or open sheets)
  size_t non_manifold_edges = 0;    ///< edges with three or more triangles
  std::vector<std::string> warnings;
};

/// Welded mesh in the map frame, metres.
struct MeshModel {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_material;
  std::vector<std::array<uint32_t, 2>> lines;  ///< explicit line elements
  uint32_t material_count = 0;
  std::vector<Eigen::Vector3f> material_colors;  ///< diffuse red, green, blue, 0 to 1
  MeshReport report;

  Eigen::Vector3f lowest = Eigen::Vector3f::Zero();
  Eigen::Vector3f highest = Eigen::Vector3f::Zero();
  double diagonal() const { return (highest - lowest).cast<double>().norm(); }
};

/// Raw geometry before welding; what a reader or a generator fills.
struct MeshSoup {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_material;
  std::vector<std::array<uint32_t, 2>> lines;
  uint32_t material_count = 1;
  std::vector<Eigen::Vector3f> material_colors;  ///< missing ones become grey
};

/// Welds vertices closer than `weld_tolerance`, drops degenerate and duplicate elements.
/// @param origin named in errors. @throws InputError on non-finite or absurd vertices
/// (beyond 1e6 m) or when nothing is left.
MeshModel weldMesh(MeshSoup soup, double weld_tolerance, const std::string& origin);

/// Reads any format that assimp knows; scale and transform of `params` are applied.
/// @throws InputError when the file is missing, broken, empty or has bad vertices.
MeshModel loadMesh(const std::string& file, const MapParameters& params);

}  // namespace edge_mcl
