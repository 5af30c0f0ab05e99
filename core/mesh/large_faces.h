/// Large faces of a mesh, which hide much behind them.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "edge_mcl/core/mesh/flat_rectangles.h"
#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

/// Walls, floors and ceilings, as flatRectangles() finds them.
class LargeFaces {
 public:
  /// @throws Error when the ray caster cannot be started or memory runs out.
  explicit LargeFaces(const MeshModel& mesh);

  /// Whether one face hides a whole box (map frame, metres): every ray from the eye to a point of
  /// the box passes through the inside of the face at more than `margin` before the point. Asked
  /// are the first few faces in the direction of the centre.
  bool hide(const Eigen::Vector3f& eye, const Eigen::Vector3f& centre, const Eigen::Vector3f& half,
            float margin) const;

 private:
  std::vector<Rectangle> faces_;
  std::unique_ptr<RayScene> scene_;  // null: there are no large faces
};

}  // namespace edge_mcl
