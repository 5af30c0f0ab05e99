/// The model's edges, sampled: what a camera can see of a building as lines.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

enum class EdgeKind : uint8_t {
  kCrease,    ///< dihedral angle above the threshold
  kBoundary,  ///< one face only
  kMaterial,  ///< between two materials on a smooth surface
  kLine,      ///< explicit line element of the file
  kContour    ///< may be the outline of a smooth surface, depending on the viewpoint
};
constexpr int kEdgeKinds = 5;
const char* edgeKindName(EdgeKind kind);

/// A straight piece of a feature edge, in the map frame.
struct EdgeLine {
  Eigen::Vector3f start, end;
  EdgeKind kind = EdgeKind::kCrease;
  /// The "line" of equations (2) and (3): a straight line, the pieces of one smooth curve (the rim
  /// of a column), or the short contour pieces of one smooth surface together.
  uint32_t group = 0;
  /// Directions from the line into its faces, perpendicular to it; zero where there is no face.
  Eigen::Vector3f into_a = Eigen::Vector3f::Zero(), into_b = Eigen::Vector3f::Zero();
  /// Contours only: normals of the two faces. The line is an outline as seen from c where
  /// exactly one of them faces c.
  Eigen::Vector3f normal_a = Eigen::Vector3f::Zero(), normal_b = Eigen::Vector3f::Zero();

  Eigen::Vector3f tangent() const { return (end - start).normalized(); }
  float length() const { return (end - start).norm(); }
};

/// A run of at most kMaxSamples neighbouring samples of one line: the unit of visibility and of
/// culling, so that a long wall can be culled piece by piece.
struct EdgeSegment {
  static constexpr uint32_t kMaxSamples = 16;
  Eigen::Vector3f centre;  ///< map frame, metres
  float radius = 0;        ///< of the sphere about the centre that holds all samples
  uint32_t line = 0;       ///< index into EdgeModel::lines
  uint32_t first_sample = 0;
  uint32_t sample_count = 0;
};

/// Bit i: sample i of the segment exists and its number in the whole model is a multiple of
/// `thinning`.
uint16_t usedSamples(const EdgeSegment& segment, uint32_t thinning);

/// Lines, ordered by group; segments, ordered by line; samples, ordered by segment.
struct EdgeModel {
  std::vector<EdgeLine> lines;
  std::vector<EdgeSegment> segments;
  /// Of every sample: metres from the centre of its segment along the tangent of its line.
  std::vector<float> sample_along;
  uint32_t group_count = 0;
  double sample_step = 0;     ///< metres, as used
  double feature_length = 0;  ///< metres, without contours
  size_t merged_pieces = 0;   ///< collinear or duplicate pieces that became part of another line

  size_t countOf(EdgeKind kind) const;
  /// Sample `i` of a segment, map frame, metres.
  Eigen::Vector3d samplePosition(const EdgeSegment& segment, uint32_t i) const {
    return segment.centre.cast<double>() +
           static_cast<double>(sample_along[segment.first_sample + i]) *
               lines[segment.line].tangent().cast<double>();
  }
};

/// Finds the feature edges of a mesh, merges collinear pieces and samples them. Fills the
/// topological counts of `mesh.report`.
EdgeModel buildEdgeModel(MeshModel* mesh, const MapParameters& params);

}  // namespace edge_mcl
