/// The world that is flown through: the building, and objects that move in it.
#pragma once

#include <memory>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// What a ray meets.
struct SceneHit {
  float distance = 0;             ///< in units of the ray's direction; infinite: none
  uint32_t object = 0;            ///< 0: the building; k: object number k - 1
  uint32_t face = 0;              ///< triangle of that mesh
  Eigen::Vector3f normal, color;  ///< normal: map axes, towards the ray's origin, unit
  bool any() const { return distance < 1e30f; }
};

/// Meshes in a ray caster. Reading is thread-safe, moving is not.
class Scene {
 public:
  static constexpr int kPacket = 16;

  explicit Scene(MeshModel building);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  /// @return its number.
  size_t addObject(MeshModel mesh);
  size_t objectCount() const;
  /// @param T_map_object takes effect at the next commit().
  void place(size_t object, const Pose& T_map_object);
  void commit();

  /// Rays that start in one point. @param directions need not be unit; rays with a NaN are left
  /// out.
  void cast(const Eigen::Vector3f& origin, const Eigen::Vector3f* directions, int count,
            SceneHit* hits) const;
  /// Whether something lies between two points.
  bool blocked(const Eigen::Vector3f& from, const Eigen::Vector3f& to) const;
  /// Distance from a point to the nearest face of the building, at most `farthest`.
  double clearance(const Eigen::Vector3d& point, double farthest) const;

  const MeshModel& building() const;
  /// Unit normal of a face in its mesh's own axes; its colour. @param object as in SceneHit.
  const Eigen::Vector3f& ownNormal(uint32_t object, uint32_t face) const;
  const Eigen::Vector3f& color(uint32_t object, uint32_t face) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
