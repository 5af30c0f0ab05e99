/// Hidden-line removal: finds the samples of the model that are visible from a camera position.
///
/// Whether a surface blocks the ray from the camera centre to a sample depends on the position of
/// the camera and not on its orientation. So all particles in one cell of space share one visible
/// set.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/edges/segment_tree.h"
#include "edge_mcl/core/mesh/large_faces.h"
#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

/// Segments and samples of an edge model that are visible from one position. Refers to the model.
struct VisibleSet {
  struct Segment {
    uint32_t index = 0;    ///< index into EdgeModel::segments
    uint16_t samples = 0;  ///< bit i: sample i of the segment is visible; at least one bit is set
    uint16_t facing = 0;   ///< facingWeight() in units of 1/65535
  };
  const EdgeModel* model = nullptr;
  std::vector<Segment> segments;  ///< ascending by index, so that lines and groups stay together
  uint32_t group_count = 0;       ///< groups with at least one visible sample
  size_t sample_count = 0;        ///< visible samples

  /// Memory of the set, bytes.
  size_t bytes() const { return sizeof(VisibleSet) + segments.capacity() * sizeof(Segment); }
  const EdgeSegment& edgeSegment(const Segment& s) const { return model->segments[s.index]; }
  const EdgeLine& line(const Segment& s) const { return model->lines[edgeSegment(s).line]; }
  /// Whether segment number k of the set is the last of its group (the line of equation (2)).
  bool endsGroup(size_t k) const {
    return k + 1 == segments.size() || line(segments[k]).group != line(segments[k + 1]).group;
  }
  /// Weight of a line in the robust model. It is 1 at a face in full view and falls to 0 as the
  /// face turns edge-on. The image of an edge-on face does not separate its far edge from its near
  /// edge.
  static double facingWeight(const Segment& s) { return s.facing / 65535.0; }
};
static_assert(EdgeSegment::kMaxSamples <= 16, "one bit per sample");

/// Cone of directions around the optical axis of a camera. Segments outside it are not examined.
struct ViewCone {
  Eigen::Vector3f axis = Eigen::Vector3f::UnitZ();  ///< unit vector, map frame
  float angle = M_PI;  ///< between the axis and the border of the cone, radians

  /// Whether a part of a sphere may lie within the cone.
  /// @param centre relative to the camera centre, metres.
  /// @param radius metres.
  bool touches(const Eigen::Vector3f& centre, float radius) const;
};

/// Number of a cell of space along each axis.
struct CellKey {
  int x = 0, y = 0, z = 0;
  bool operator==(const CellKey& o) const { return x == o.x && y == o.y && z == o.z; }
  bool operator<(const CellKey& o) const {
    return x != o.x ? x < o.x : (y != o.y ? y < o.y : z < o.z);
  }
};

/// Finds visible sets and caches them by cell. Thread-safe. Results are shared and immutable.
class Visibility {
 public:
  /// Keeps references to mesh and model, which must outlive this object.
  /// @throws Error when the ray caster cannot be started or memory runs out.
  Visibility(const MeshModel& mesh, const EdgeModel& model, const VisibilityParameters& params);
  ~Visibility();
  Visibility(const Visibility&) = delete;
  Visibility& operator=(const Visibility&) = delete;

  /// Finds the visible set of exactly one position (metres, map frame), without the cache.
  /// @param thinning only samples whose number is a multiple of this are examined.
  /// @param cone segments outside it are not examined and not part of the set.
  VisibleSet exact(const Eigen::Vector3d& position, uint32_t thinning = 1,
                   const ViewCone& cone = {}) const;

  /// The same as exact() without its hierarchy: every sample of the model is tested. For tests.
  VisibleSet exhaustive(const Eigen::Vector3d& position) const;

  /// Visible set of a cell, from the centre of the cell. The first call finds it, later calls read
  /// it from the cache.
  std::shared_ptr<const VisibleSet> cached(const CellKey& cell) const;
  /// Cell that holds a position (metres, map frame).
  CellKey cellOf(const Eigen::Vector3d& position) const;
  /// Centre of a cell, metres, map frame.
  Eigen::Vector3d cellCentre(const CellKey& cell) const;

  /// Side of a cell, metres.
  double cellSize() const { return cell_size_; }
  /// A surface closer than this to a sample does not hide it, metres.
  double occlusionTolerance() const { return tolerance_; }
  /// The same for the sample of an explicit line. It is larger beside the faces of a scan, which
  /// lie beside the lines that were found with it.
  double occlusionToleranceOfLines() const { return tolerance_of_lines_; }
  /// The faces of the model in the ray caster; null: it has none.
  const RayScene* scene() const { return scene_.get(); }
  const EdgeModel& model() const { return model_; }

  /// Calls of cached() that found or missed a cell, cells dropped, and cells and bytes in the cache
  /// now.
  struct CacheStatistics {
    uint64_t hits = 0, misses = 0, dropped = 0;
    size_t cells = 0, bytes = 0;
  };
  CacheStatistics statistics() const;

 private:
  struct Cache;
  VisibleSet tested(const Eigen::Vector3f& eye, uint32_t thinning, const ViewCone& cone,
                    const std::vector<uint32_t>& candidates) const;
  void removeHidden(const Eigen::Vector3f& eye, std::vector<VisibleSet::Segment>* segments) const;
  const EdgeModel& model_;
  VisibilityParameters params_;
  double cell_size_;
  double tolerance_, tolerance_of_lines_;
  std::unique_ptr<RayScene> scene_;  // null: the model has no faces
  LargeFaces large_faces_;
  SegmentTree tree_;
  std::unique_ptr<Cache> cache_;
};

}  // namespace edge_mcl
