/// A mesh in the ray caster. This header needs no Embree.
#pragma once

#include "edge_mcl/core/mesh_model.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace edge_mcl {

/// Adds the mesh's triangles to an Embree scene, which the caller commits; faces keep their
/// numbers. @throws Error when memory runs out.
void attachMesh(RTCDeviceTy* device, RTCSceneTy* scene, const MeshModel& mesh);

}  // namespace edge_mcl
