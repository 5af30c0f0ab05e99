/// Truncated distance to the model's surfaces, on a sparse grid of voxels.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Stores for every voxel near a surface the distance of its centre from the nearest face, and the
/// direction away from this face. Between centres the distance is continued linearly, which is
/// exact beside a plane, on both of its sides. Voxels are stored in bricks of 8 x 8 x 8. All bricks
/// that are farther from every surface than the truncation share one empty brick.
class DistanceField {
 public:
  struct Options {
    double truncation = 0.3;  ///< m
    double voxel_size = 0;    ///< m; 0 = automatic
    /// Automatic voxels grow until the field needs at most this memory.
    double most_bytes = 256e6;
  };

  /// Measures all voxels, which takes seconds for a building.
  /// @throws InputError when the mesh has no faces, or when voxels of the given size need more than
  ///   `most_bytes`.
  DistanceField(const MeshModel& mesh, const Options& options);

  double truncation() const { return truncation_; }
  double voxelSize() const { return voxel_size_; }
  /// Size in memory, bytes.
  size_t size() const { return 4 * (brick_of_.size() + voxels_.size()); }

  /// Distance and gradient at a point, from the voxel that holds the point.
  struct Reading {
    bool near = false;    ///< false: farther from every surface than the truncation
    double distance = 0;  ///< m; positive on the side of the surface that `gradient` points to
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  ///< gradient of the distance, map axes
  };
  /// Reads the field at a point (map frame, metres).
  Reading at(const Eigen::Vector3d& point) const;

  /// The grid as the kernels use it. A voxel is one word. Its low byte is the distance in steps of
  /// `distance_step` (255: far). The other bytes are the gradient along x, y and z in units of
  /// 1/127, signed.
  struct Grid {
    Eigen::Vector3d origin;  ///< corner of the first voxel, map frame, metres
    double voxel_size, truncation;
    double distance_step;   ///< m
    int bricks[3];          ///< number of bricks along x, y, z
    const int32_t* brick;   ///< number of the brick at every place, x fastest; 0 = far
    const uint32_t* voxel;  ///< 512 voxels of every brick, x fastest
  };
  Grid grid() const;

  static constexpr int kBrick = 8;
  static constexpr int kBrickVoxels = kBrick * kBrick * kBrick;
  static constexpr uint32_t kFar = 255;

  /// Hash of everything that determines a field: the mesh, the options and the method.
  static uint64_t hashOf(const MeshModel& mesh, const Options& options);
  /// Writes the field to a binary file, little-endian.
  /// @throws InputError when the file cannot be written.
  void write(const std::string& file, uint64_t hash) const;
  /// Reads a field. @throws InputError when the file is missing or broken, or has another hash.
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

/// Returns the field of a model file. It reads a stored field if there is one. Otherwise it makes
/// the field and stores it beside the model. If that place cannot be written, it stores the field
/// in $XDG_CACHE_HOME/edge_mcl (~/.cache/edge_mcl).
/// @param warning gets one line when the field cannot be stored.
DistanceField storedDistanceField(const MeshModel& mesh, const DistanceField::Options& options,
                                  const std::string& model_file, std::string* warning);

}  // namespace edge_mcl
