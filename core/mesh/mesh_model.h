/// Triangle mesh and line elements of a building or an object.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Faults that were found and repaired in a mesh. buildEdgeModel() fills flipped_pairs and what
/// follows it up to covered_length.
struct MeshReport {
  size_t vertices_read = 0;         ///< number of vertices before welding
  size_t degenerate_triangles = 0;  ///< dropped: no area or no corners
  size_t duplicate_triangles = 0;   ///< dropped: same three vertices as another triangle
  size_t zero_length_lines = 0;     ///< dropped: both ends are one vertex
  size_t flipped_pairs = 0;         ///< neighbouring triangles with opposite winding
  size_t boundary_edges = 0;        ///< edges with one triangle (holes or open sheets)
  size_t non_manifold_edges = 0;    ///< edges with three or more triangles
  size_t covered_edges = 0;         ///< dropped: other faces cover them
  double covered_length = 0;        ///< of all dropped pieces of edges, metres
  /// Unit that the file states, for people; empty when it states none.
  std::string unit;
  /// Names of the objects of the file with their numbers of triangles and lines, without those that
  /// `map.include` and `map.exclude` leave out.
  std::map<std::string, size_t> objects;
  std::vector<std::string> warnings;
};

/// Welded mesh in the map frame, metres.
struct MeshModel {
  /// The map frame's origin in the coordinates of the file after scale and transform of the map
  /// parameters, metres. It is not zero when the file holds coordinates of a country.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;  ///< three vertex numbers each
  std::vector<uint32_t> triangle_material;         ///< material number of every triangle
  /// Whether a triangle only hides what is behind it: its creases are no edges. Empty: none does.
  std::vector<bool> hides_only;
  /// Explicit line elements, two vertex numbers each.
  std::vector<std::array<uint32_t, 2>> lines;
  /// Pieces of straight lines that are no feature edges, whatever the faces say (start and end, map
  /// frame, metres). See leaveOutDoubted().
  std::vector<std::array<Eigen::Vector3d, 2>> left_out;
  uint32_t material_count = 0;
  std::vector<Eigen::Vector3f> material_colors;  ///< diffuse red, green and blue, each 0 to 1
  MeshReport report;

  /// Corners of the bounding box.
  Eigen::Vector3f lowest = Eigen::Vector3f::Zero();
  Eigen::Vector3f highest = Eigen::Vector3f::Zero();
  double diagonal() const { return (highest - lowest).cast<double>().norm(); }
};

/// Geometry before welding, in the map frame, metres. A reader or a generator fills it.
struct MeshSoup {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_material;
  std::vector<bool> hides_only;  ///< see MeshModel; empty: none
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

}  // namespace edge_mcl
