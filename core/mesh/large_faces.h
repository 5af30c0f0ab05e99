/// Large faces of a mesh, which hide much behind them.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Walls, floors and ceilings, as flatRectangles() finds them.
class LargeFaces {
 public:
  /// @throws Error when the ray caster cannot be started or memory runs out.
  explicit LargeFaces(const MeshModel& mesh);
  ~LargeFaces();
  LargeFaces(const LargeFaces&) = delete;
  LargeFaces& operator=(const LargeFaces&) = delete;

  /// Whether one face hides a whole box (map frame, metres): every ray from the eye to a point of
  /// the box passes through the inside of the face at more than `margin` before the point. Asked
  /// are the first few faces in the direction of the centre.
  bool hide(const Eigen::Vector3f& eye, const Eigen::Vector3f& centre, const Eigen::Vector3f& half,
            float margin) const;
  size_t count() const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace edge_mcl
