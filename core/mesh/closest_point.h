/// The nearest face of a mesh.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// The point of a triangle that is closest to `p` (C. Ericson, "Real-Time Collision Detection",
/// section 5.1.5: by the Voronoi regions of corners, edges and face).
Eigen::Vector3d closestPointOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Finds the face closest to a point. Safe to use from several threads.
class ClosestFace {
 public:
  /// The mesh must outlive this object. @throws Error when memory runs out.
  explicit ClosestFace(const MeshModel& mesh);
  ~ClosestFace();
  ClosestFace(const ClosestFace&) = delete;
  ClosestFace& operator=(const ClosestFace&) = delete;

  struct Hit {
    bool found = false;
    uint32_t face = 0;
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    double distance = 0;
  };
  /// @param reach m; faces farther away are not found.
  Hit find(const Eigen::Vector3d& point, double reach) const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace edge_mcl
