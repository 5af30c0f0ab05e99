/// Hidden-line removal: which samples of the model a camera at a position can see.
///
/// Whether something blocks the ray from a camera centre to a sample depends on the position
/// alone, not on the camera's orientation; so particles in one cell of space share the answer.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "edge_mcl/core/edge_model.h"
#include "edge_mcl/core/parameters.h"

namespace edge_mcl {

/// Visible samples as structure of arrays, ready for the likelihood kernels.
/// Samples are ordered; a *segment* is a run of one EdgeLine (one tangent), a *group* a run of
/// segments (one line of equation 2).
struct VisibleSet {
  struct Segment {
    Eigen::Vector3f tangent;
    Eigen::Vector3f centre;  ///< of the bounding sphere of its samples, map frame
    float radius = 0;
    /// 1 for a line at a face in full view, falling to 0 as the face turns edge-on: then its far
    /// edge cannot be told from its near one in the image. Robust model only.
    float facing = 1;
    uint32_t first = 0, count = 0;
    bool ends_group = false;
    uint32_t line = 0;  ///< index into EdgeModel::lines
  };
  std::vector<Eigen::Vector3f> position;  ///< map frame
  std::vector<Segment> segments;
  uint32_t group_count = 0;
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
  VisibleSet exact(const Eigen::Vector3d& position) const;

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
  const EdgeModel& model_;
  VisibilityParameters params_;
  double cell_size_;
  double tolerance_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Cache> cache_;
};

}  // namespace edge_mcl
