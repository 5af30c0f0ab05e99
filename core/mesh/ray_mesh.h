/// Access to a mesh in the ray caster. This header needs no header of Embree.
#pragma once

#include "edge_mcl/core/mesh/mesh_model.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace edge_mcl {

/// Adds the triangles of a mesh to an Embree scene. Faces keep their numbers. The caller commits
/// the scene.
/// @throws Error when memory runs out.
void attachMesh(RTCDeviceTy* device, RTCSceneTy* scene, const MeshModel& mesh);

/// Whether a surface lies between two points (map frame, metres).
/// @param margin share of the way that is ignored at its start.
/// @param end_margin share of the way that is ignored at its end.
bool isBlocked(RTCSceneTy* scene, const Eigen::Vector3f& from, const Eigen::Vector3f& to,
               float margin, float end_margin);

}  // namespace edge_mcl
