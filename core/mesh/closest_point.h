/// Search for the face of a mesh that is nearest to a point.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

/// Returns the point of the triangle (a, b, c) that is closest to `p`. Source: C. Ericson,
/// "Real-Time Collision Detection", section 5.1.5 (by the Voronoi regions of corners, edges and
/// face).
Eigen::Vector3d closestPointOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Finds the face of a mesh that is closest to a point. Safe to use from several threads.
class ClosestFace {
 public:
  /// The mesh must outlive this object.
  /// @throws Error when the ray caster cannot be started or memory runs out.
  explicit ClosestFace(const MeshModel& mesh);
  ~ClosestFace();
  ClosestFace(const ClosestFace&) = delete;
  ClosestFace& operator=(const ClosestFace&) = delete;

  struct Hit {
    bool found = false;  ///< false: no face within reach
    uint32_t face = 0;   ///< index into MeshModel::triangles
    /// Point of the face that is closest, map frame.
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double distance = 0;  ///< m; the reach when no face is found
  };
  /// Finds the closest face.
  /// @param point map frame, metres.
  /// @param reach largest distance of a face, m.
  Hit find(const Eigen::Vector3d& point, double reach) const;

 private:
  const MeshModel& mesh_;
  std::unique_ptr<RayScene> scene_;
};

}  // namespace edge_mcl
