/// A mesh in the ray caster. This header needs no Embree.
#pragma once

#include "edge_mcl/core/mesh/mesh_model.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace edge_mcl {

/// Adds the mesh's triangles to an Embree scene, which the caller commits; faces keep their
/// numbers. @throws Error when memory runs out.
void attachMesh(RTCDeviceTy* device, RTCSceneTy* scene, const MeshModel& mesh);

/// Whether something lies between two points. @param margin share of the way that does not count at
/// its begin; at its end, `end_margin`.
bool isBlocked(RTCSceneTy* scene, const Eigen::Vector3f& from, const Eigen::Vector3f& to,
               float margin, float end_margin);

}  // namespace edge_mcl
