/// The part of a model's space in which a camera can be.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

class ClosestFace;

/// Tells whether a camera can be at a position. A position is free when surfaces surround it and no
/// surface is closer than the clearance. Some models surround nothing (no faces, an object, a room
/// without walls). Their free space is everything inside their bounds, as far as the clearance
/// allows.
class FreeSpace {
 public:
  struct Options {
    double clearance = 0.2;  ///< smallest distance from every surface, m
    double enclosure = 0.7;  ///< smallest share of all directions that hit a surface
  };
  /// Measures the free volume. The mesh must outlive this object.
  /// @throws Error when the ray caster cannot be started or memory runs out.
  /// @throws InputError when the model is empty.
  FreeSpace(const MeshModel& mesh, const Options& options);
  ~FreeSpace();
  FreeSpace(const FreeSpace&) = delete;
  FreeSpace& operator=(const FreeSpace&) = delete;

  /// Whether a camera can be at a position (map frame, metres).
  bool contains(const Eigen::Vector3d& position) const;
  /// Whether an estimated position (map frame, metres) is possible. This is less strict than
  /// contains(): half the clearance is enough. If the model surrounds nothing, positions outside
  /// its bounds are possible, too.
  bool admits(const Eigen::Vector3d& position) const;
  /// Whether the model surrounds space. If not, everything inside the bounds counts as surrounded.
  bool isEnclosed() const { return enclosed_; }
  /// Free volume in m^3, to some per cent.
  double volume() const { return volume_; }

  /// Free positions (map frame) on a cubic grid, in a fixed order.
  /// @param spacing largest distance between neighbours along an axis, m.
  std::vector<Eigen::Vector3d> places(double spacing) const;

 private:
  bool isClear(const Eigen::Vector3d& position, double clearance) const;
  bool isSurrounded(const Eigen::Vector3d& position) const;
  Options options_;
  Eigen::Vector3d low_, high_;
  std::unique_ptr<RayScene> scene_;
  std::unique_ptr<ClosestFace> closest_;
  bool enclosed_ = false;
  double volume_ = 0;
};

}  // namespace edge_mcl
