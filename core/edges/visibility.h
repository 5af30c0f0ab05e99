/// Hidden-line removal: which samples of the model a camera at a position can see.
///
/// Whether something blocks the ray from a camera centre to a sample depends on the position
/// alone, not on the camera's orientation; so particles in one cell of space share the answer.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// What can be seen of an edge model from one place: which of its segments, and which samples of
/// them. Refers to the model.
struct VisibleSet {
  struct Segment {
    uint32_t index = 0;    ///< into EdgeModel::segments
    uint16_t samples = 0;  ///< bit i: sample i of the segment is visible; at least one is
    uint16_t facing = 0;   ///< see facingWeight, in units of 1/65535
  };
  const EdgeModel* model = nullptr;
  std::vector<Segment> segments;  ///< ascending by index, so that lines and groups are in sequence
  uint32_t group_count = 0;
  size_t sample_count = 0;

  const EdgeSegment& edgeSegment(const Segment& s) const { return model->segments[s.index]; }
  const EdgeLine& line(const Segment& s) const { return model->lines[edgeSegment(s).line]; }
  /// Whether segment number k is the last of its group (line of equation 2).
  bool endsGroup(size_t k) const {
    return k + 1 == segments.size() || line(segments[k]).group != line(segments[k + 1]).group;
  }
  /// 1 for a line at a face in full view, falling to 0 as the face turns edge-on: then its far
  /// edge cannot be told from its near one in the image. Robust model only.
  static double facingWeight(const Segment& s) { return s.facing / 65535.0; }
};
static_assert(EdgeSegment::kMaxSamples <= 16, "one bit per sample");

/// Directions around the optical axis of a camera, for leaving out what it cannot see anyway.
struct ViewCone {
  Eigen::Vector3f axis = Eigen::Vector3f::UnitZ();  ///< unit vector, map frame
  float angle = M_PI;                               ///< between the axis and the border, radians

  /// Whether some of a sphere may lie within. @param centre relative to the eye.
  bool touches(const Eigen::Vector3f& centre, float radius) const;
};

/// Key of a cell of space.
struct CellKey {
  int x = 0, y = 0, z = 0;
  bool operator==(const CellKey& o) const { return x == o.x && y == o.y && z == o.z; }
  bool operator<(const CellKey& o) const {
    return x != o.x ? x < o.x : (y != o.y ? y < o.y : z < o.z);
  }
};

/// Thread-safe; results are shared and immutable.
class Visibility {
 public:
  /// Keeps references to mesh and model: both must outlive this object.
  Visibility(const MeshModel& mesh, const EdgeModel& model, const VisibilityParameters& params);
  ~Visibility();
  Visibility(const Visibility&) = delete;
  Visibility& operator=(const Visibility&) = delete;

  /// Exact answer for one position (metres, map frame): the oracle.
  /// @param thinning only every so many-th sample of the model is looked at.
  /// @param cone segments outside it are left out, and not counted as hidden or visible.
  VisibleSet exact(const Eigen::Vector3d& position, uint32_t thinning = 1,
                   const ViewCone& cone = {}) const;

  /// Answer for the cell that holds the position; computed once, then cached.
  std::shared_ptr<const VisibleSet> cached(const CellKey& cell) const;
  CellKey cellOf(const Eigen::Vector3d& position) const;
  Eigen::Vector3d cellCentre(const CellKey& cell) const;

  double cellSize() const { return cell_size_; }
  double occlusionTolerance() const { return tolerance_; }
  bool exactMode() const { return params_.exact; }
  const EdgeModel& model() const { return model_; }

  struct CacheStatistics {
    uint64_t hits = 0, misses = 0, dropped = 0;
    size_t cells = 0;
  };
  CacheStatistics statistics() const;

 private:
  struct Scene;
  struct Cache;
  void removeHidden(const Eigen::Vector3f& eye, std::vector<VisibleSet::Segment>* segments) const;
  const EdgeModel& model_;
  VisibilityParameters params_;
  double cell_size_;
  double tolerance_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Cache> cache_;
};

}  // namespace edge_mcl
