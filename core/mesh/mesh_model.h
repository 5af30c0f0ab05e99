/// Triangle mesh and line elements of a building or an object.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Faults that were found and repaired in a mesh. buildEdgeModel() fills the last three counts.
struct MeshReport {
  size_t vertices_read = 0;         ///< number of vertices before welding
  size_t degenerate_triangles = 0;  ///< dropped: no area or no corners
  size_t duplicate_triangles = 0;   ///< dropped: same three vertices as another triangle
  size_t zero_length_lines = 0;     ///< dropped: both ends are one vertex
  size_t flipped_pairs = 0;         ///< neighbouring triangles with opposite winding
  size_t boundary_edges = 0;        ///< edges with one triangle (holes or open sheets)
  size_t non_manifold_edges = 0;    ///< edges with three or more triangles
  std::vector<std::string> warnings;
};

/// Welded mesh in the map frame, metres.
struct MeshModel {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< three vertex numbers each
  std::vector<uint32_t> triangle_material;         ///< material number of every triangle
  /// Explicit line elements, two vertex numbers each.
  std::vector<std::array<uint32_t, 2>> lines;
  uint32_t material_count = 0;
  std::vector<Eigen::Vector3f> material_colors;  ///< diffuse red, green and blue, each 0 to 1
  MeshReport report;

  /// Corners of the bounding box.
  Eigen::Vector3f lowest = Eigen::Vector3f::Zero();
  Eigen::Vector3f highest = Eigen::Vector3f::Zero();
  double diagonal() const { return (highest - lowest).cast<double>().norm(); }
};

/// Raw geometry before welding, in the map frame, metres. A reader or a generator fills it.
struct MeshSoup {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_material;
  std::vector<std::array<uint32_t, 2>> lines;
  uint32_t material_count = 1;
  std::vector<Eigen::Vector3f> material_colors;  ///< missing colours become grey
};

/// Welds vertices that are at most `weld_tolerance` metres apart, and drops degenerate and
/// duplicate elements.
/// @param origin named in errors.
/// @throws InputError when a vertex is not finite or absurd (beyond 1e6 m), or when no element
///   remains.
MeshModel weldMesh(MeshSoup soup, double weld_tolerance, const std::string& origin);

/// Reads a model file of any format that assimp knows, and applies scale and transform of `params`.
/// @throws InputError when the file is missing, broken or empty or has bad vertices, or when the
///   model is so far from the file's origin that its coordinates have an error of more than 10 mm.
MeshModel loadMesh(const std::string& file, const MapParameters& params);

}  // namespace edge_mcl
