/// Where inside a model a camera can be.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

class ClosestFace;

/// Inside is what surfaces surround, and not too close to any of them. A model without faces, or
/// one that surrounds nothing (an object, a room without walls), is free everywhere in its bounds,
/// as far as the clearance allows.
class FreeSpace {
 public:
  struct Options {
    double clearance = 0.2;  ///< m to every surface
    double enclosure = 0.7;  ///< share of all directions in which there must be a surface
  };
  /// The mesh must outlive this object. @throws Error when memory runs out, InputError when the
  /// model is empty.
  FreeSpace(const MeshModel& mesh, const Options& options);
  ~FreeSpace();
  FreeSpace(const FreeSpace&) = delete;
  FreeSpace& operator=(const FreeSpace&) = delete;

  bool contains(const Eigen::Vector3d& position) const;
  /// Less strict, for poses that were estimated: half the clearance is enough, and where the model
  /// surrounds nothing at all, places outside its bounds count, too.
  bool admits(const Eigen::Vector3d& position) const;
  /// False: nothing is surrounded, everything in the bounds counts.
  bool isEnclosed() const { return enclosed_; }
  /// m^3, to some per cent.
  double volume() const { return volume_; }

  /// Free places on a cubic grid, in a fixed order.
  std::vector<Eigen::Vector3d> places(double spacing) const;

 private:
  struct Scene;
  bool isClear(const Eigen::Vector3d& position, double clearance) const;
  bool isSurrounded(const Eigen::Vector3d& position) const;
  Options options_;
  Eigen::Vector3d low_, high_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<ClosestFace> closest_;
  bool enclosed_ = false;
  double volume_ = 0;
};

}  // namespace edge_mcl
