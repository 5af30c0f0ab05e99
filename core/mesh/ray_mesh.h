/// Access to a mesh in the ray caster. This header needs no header of Embree.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "edge_mcl/core/mesh/mesh_model.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace edge_mcl {

/// Adds the triangles of a mesh to an Embree scene. Faces keep their numbers. The caller commits
/// the scene.
/// @throws Error when memory runs out.
void attachMesh(RTCDeviceTy* device, RTCSceneTy* scene, const MeshModel& mesh);

/// An Embree device with a committed scene that holds one mesh.
class RayScene {
 public:
  enum class Rays {
    kFast,
    kRobust,  ///< a ray through a shared edge or vertex does not slip between the faces
    kEvery    ///< like kRobust, and the filter of a query sees every hit
  };
  /// @throws Error when the ray caster cannot be started or memory runs out.
  explicit RayScene(const MeshModel& mesh, Rays rays = Rays::kFast);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;
  RTCSceneTy* get() const { return scene_; }

 private:
  RTCDeviceTy* device_;
  RTCSceneTy* scene_;
};

/// The first surface on a ray.
struct RayHit {
  uint32_t triangle = 0;
  float along = 0;     ///< of the ray, in lengths of its direction
  float u = 0, v = 0;  ///< barycentric coordinates of the second and third vertex
};

/// @param from, direction map frame, metres; the direction may have any length.
/// @param begin, end of the ray, in lengths of its direction.
/// @return nothing when the ray meets no surface.
std::optional<RayHit> firstHit(RTCSceneTy* scene, const Eigen::Vector3f& from,
                               const Eigen::Vector3f& direction, float begin, float end);

/// First surfaces on rays that start at one point and lie side by side.
/// @param directions, count as for firstHit(); a direction that is not finite meets nothing.
/// @param along of each ray, in lengths of its direction; infinite where it meets no surface.
void firstHits(RTCSceneTy* scene, const Eigen::Vector3f& from, const Eigen::Vector3f* directions,
               size_t count, float* along);

/// Whether a surface lies between two points (map frame, metres).
/// @param margin share of the way that is ignored at its start.
/// @param end_margin share of the way that is ignored at its end.
bool isBlocked(RTCSceneTy* scene, const Eigen::Vector3f& from, const Eigen::Vector3f& to,
               float margin, float end_margin);

}  // namespace edge_mcl
