/// Casts rays into a simulated world: the building and objects that move in it.
#pragma once

#include <memory>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// First surface that a ray meets.
struct SceneHit {
  float distance = 0;             ///< in lengths of the ray's direction; infinite: no hit
  uint32_t object = 0;            ///< 0: the building; k: object number k - 1
  uint32_t face = 0;              ///< number of the triangle in its mesh
  Eigen::Vector3f normal, color;  ///< normal: unit, map axes, towards the ray's origin
  bool any() const { return distance < 1e30f; }
};

/// Meshes in a ray caster (Embree). Several threads may call the const methods at the same time,
/// but not while addObject(), place() or commit() runs.
class Scene {
 public:
  static constexpr int kPacket = 16;  ///< most rays of one cast()

  /// @throws InputError when the mesh has no faces, Error when the ray caster cannot be started.
  explicit Scene(MeshModel building);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// Adds an object at the map's origin. @return the object's number, from 0 on.
  size_t addObject(MeshModel mesh);
  size_t objectCount() const;
  /// Sets the pose of an object. It takes effect at the next commit().
  void place(size_t object, const Pose& T_map_object);
  /// Makes the poses set by place() visible to rays.
  void commit();

  /// Finds the first hit of up to kPacket rays that start in one point (map, m).
  /// @param directions map axes, of any length; a ray with a non-finite number hits nothing.
  /// @param hits one for every ray.
  void cast(const Eigen::Vector3f& origin, const Eigen::Vector3f* directions, int count,
            SceneHit* hits) const;
  /// Whether a surface lies between two points (map, m).
  bool blocked(const Eigen::Vector3f& from, const Eigen::Vector3f& to) const;
  /// Distance from a point (map, m) to the nearest face of the building, at most `farthest`.
  double clearance(const Eigen::Vector3d& point, double farthest) const;

  const MeshModel& building() const;
  /// Unit normal of a face in the axes of its own mesh. @param object as in SceneHit.
  const Eigen::Vector3f& ownNormal(uint32_t object, uint32_t face) const;
  /// Colour of a face. @param object as in SceneHit.
  const Eigen::Vector3f& color(uint32_t object, uint32_t face) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
