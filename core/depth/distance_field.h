/// Truncated distance to the model's surfaces, on a sparse grid.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Every voxel near a surface knows the distance of its centre from the nearest face and the
/// direction away from it. Between centres the distance is continued linearly, which is exact
/// beside a plane, and on both sides of it. Voxels live in bricks of 8 x 8 x 8; what is farther
/// from all surfaces than the truncation has no brick of its own.
class DistanceField {
 public:
  struct Options {
    double truncation = 0.3;    ///< m
    double voxel_size = 0;      ///< m; 0 = automatic
    double most_bytes = 256e6;  ///< automatic voxels grow until the field fits
  };

  /// Measures all voxels: seconds for a building.
  /// @throws InputError when the mesh has no faces.
  DistanceField(const MeshModel& mesh, const Options& options);

  double truncation() const { return truncation_; }
  double voxelSize() const { return voxel_size_; }
  /// Bytes in memory.
  size_t size() const { return 4 * (brick_of_.size() + voxels_.size()); }

  /// What the nearest voxel says of a point.
  struct Reading {
    bool near = false;    ///< false: farther from every surface than the truncation
    double distance = 0;  ///< m; its sign is that of the side of the surface, by `gradient`
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< of the distance, map axes
  };
  Reading at(const Eigen::Vector3d& point) const;

  /// The grid as the kernels see it. A voxel is one word: low byte distance in steps of
  /// `distance_step` (255: far), the others the gradient in 1/127, signed.
  struct Grid {
    Eigen::Vector3d origin;  ///< corner of the first voxel, map frame
    double voxel_size, truncation;
    double distance_step;   ///< m
    int bricks[3];          ///< along x, y, z
    const int32_t* brick;   ///< x fastest; number of the brick, 0 = far
    const uint32_t* voxel;  ///< 512 of every brick, x fastest
  };
  Grid grid() const;

  static constexpr int kBrick = 8;
  static constexpr int kBrickVoxels = kBrick * kBrick * kBrick;
  static constexpr uint32_t kFar = 255;

  /// Identifies what a field is made from: the mesh, the options and the method.
  static uint64_t hashOf(const MeshModel& mesh, const Options& options);
  /// Binary, little-endian. @throws InputError when the file cannot be written.
  void write(const std::string& file, uint64_t hash) const;
  /// @throws InputError when the file is missing, broken or made from something else.
  static DistanceField read(const std::string& file, uint64_t hash);

 private:
  DistanceField() = default;
  double distanceStep() const { return (truncation_ + voxel_size_) / (kFar - 1); }

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double voxel_size_ = 0, truncation_ = 0;
  int32_t bricks_[3] = {0, 0, 0};
  std::vector<int32_t> brick_of_;
  std::vector<uint32_t> voxels_;
};

/// The field of a model read from a file: from disk if it was made before, else made and stored:
/// beside the model, or where that cannot be written in $XDG_CACHE_HOME/edge_mcl (~/.cache).
/// @param warning gets one line when it cannot be stored.
DistanceField storedDistanceField(const MeshModel& mesh, const DistanceField::Options& options,
                                  const std::string& model_file, std::string* warning);

}  // namespace edge_mcl
