/// A room with a stair.
#pragma once

#include "support/scenes.h"

namespace edge_mcl::test {

constexpr float kStepRise = 0.18f, kStepRun = 0.27f;  // m

/// Twelve steps along x in a room, with two cupboards.
inline MeshModel stairs() {
  MeshSoup soup;
  addBox(&soup, {0, 0, 0}, {7, 2.6f, 4}, 0, true);
  addBox(&soup, {1.4f, 1.7f, 0}, {2.6f, 2.5f, 1.1f});
  addBox(&soup, {3.4f, 2.2f, 1.5f}, {4.6f, 2.599f, 2.3f});
  for (int i = 0; i < 12; ++i)
    addBox(&soup, {2 + kStepRun * i, 0, 0}, {2 + kStepRun * (i + 1), 1.6f, kStepRise * (i + 1)});
  return weldMesh(std::move(soup), 1e-6, "stairs");
}

/// One step on.
inline Eigen::Vector3d oneStep() { return Eigen::Vector3f(kStepRun, 0, kStepRise).cast<double>(); }

/// Pose of a camera before the stairs, T_map_camera.
inline Pose beforeStairs() { return lookAlong({0.6, 0.8, 1.5}, {1, 0.05, -0.15}); }

}  // namespace edge_mcl::test
