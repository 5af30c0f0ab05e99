/// The feature edges of a model, as lines with samples.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Kinds of feature edges.
enum class EdgeKind : uint8_t {
  kCrease,    ///< the normals of its faces differ by at least `map.crease_angle_deg`
  kBoundary,  ///< has only one face
  kMaterial,  ///< lies between two materials on a smooth surface
  kLine,      ///< explicit line element of the file
  kContour    ///< is the outline of a smooth surface from some viewpoints
};
constexpr int kEdgeKinds = 5;
/// Name of a kind: crease, boundary, material, line or contour.
const char* edgeKindName(EdgeKind kind);

/// A straight feature edge, in the map frame, metres.
struct EdgeLine {
  Eigen::Vector3f start, end;
  EdgeKind kind = EdgeKind::kCrease;
  /// Number of the group that the line belongs to. A group is the "line" of equations (2) and (3):
  /// one straight line, the pieces of one smooth curve (the rim of a column), or all short contour
  /// pieces of one smooth surface.
  uint32_t group = 0;
  /// Unit vectors from the line into its faces, perpendicular to the line. Zero where there is no
  /// face.
  Eigen::Vector3f into_a = Eigen::Vector3f::Zero(), into_b = Eigen::Vector3f::Zero();
  /// Unit normals of the two faces, used for contours. The line is an outline for a camera at c
  /// when exactly one of the two faces faces c.
  Eigen::Vector3f normal_a = Eigen::Vector3f::Zero(), normal_b = Eigen::Vector3f::Zero();

  Eigen::Vector3f tangent() const { return (end - start).normalized(); }
  float length() const { return (end - start).norm(); }
};

/// A run of at most kMaxSamples neighbouring samples of one line. It is the unit of visibility and
/// of culling, so that a long wall can be culled piece by piece.
struct EdgeSegment {
  static constexpr uint32_t kMaxSamples = 16;
  Eigen::Vector3f centre;  ///< map frame, metres
  float radius = 0;        ///< of the sphere about the centre that holds all samples, metres
  uint32_t line = 0;       ///< index into EdgeModel::lines
  uint32_t first_sample = 0;
  uint32_t sample_count = 0;
};

/// Bits of the samples that remain after thinning. Bit i is set when sample i of the segment exists
/// and its number in the whole model is a multiple of `thinning`.
uint16_t usedSamples(const EdgeSegment& segment, uint32_t thinning);

/// All lines, segments and samples of a model. Lines are ordered by group, segments by line,
/// samples by segment.
struct EdgeModel {
  std::vector<EdgeLine> lines;
  std::vector<EdgeSegment> segments;
  /// Position of every sample: metres from the centre of its segment along the tangent of its line.
  std::vector<float> sample_along;
  uint32_t group_count = 0;
  /// Distance between samples, metres; set also when `map.sample_step` is automatic.
  double sample_step = 0;
  double feature_length = 0;  ///< length of all lines without contours, metres
  size_t merged_pieces = 0;   ///< collinear or duplicate pieces that were merged into another line

  /// Number of lines of a kind.
  size_t countOf(EdgeKind kind) const;
  /// Position of sample `i` of a segment, map frame, metres.
  Eigen::Vector3d samplePosition(const EdgeSegment& segment, uint32_t i) const {
    return segment.centre.cast<double>() +
           static_cast<double>(sample_along[segment.first_sample + i]) *
               lines[segment.line].tangent().cast<double>();
  }
};

/// Finds the feature edges of a mesh, merges collinear pieces and samples them. It fills the counts
/// of edges in `mesh->report`.
EdgeModel buildEdgeModel(MeshModel* mesh, const MapParameters& params);

}  // namespace edge_mcl
