#include "edge_mcl/core/depth/distance_field.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/mesh/closest_point.h"

namespace edge_mcl {

namespace {

/// Numbers of all bricks. Bricks with a surface within reach are counted from one, the others have
/// the number 0.
struct BrickLayout {
  int32_t bricks[3];
  std::vector<int32_t> brick_of;
  int32_t count = 1;  // brick 0 is the empty one
};

/// Marks the bricks of a cube that have a surface within reach. It divides the cube into eighths
/// until a part is one brick.
/// @param size bricks along a side of the cube, a power of two.
/// @return number of marked bricks; the search stops early when it exceeds `most`.
size_t mark(const ClosestFace& faces, const Eigen::Vector3d& origin, double side, double reach,
            const Eigen::Vector3i& corner, int size, size_t most, BrickLayout* layout) {
  const Eigen::Map<const Eigen::Vector3i> bricks(layout->bricks);
  if ((corner.array() >= bricks.array()).any()) return 0;
  const Eigen::Vector3d centre =
      origin + side * (corner.cast<double>() + Eigen::Vector3d::Constant(size / 2.0));
  if (!faces.find(centre, reach + std::sqrt(3.0) / 2 * side * size).found) return 0;
  if (size == 1) {
    layout->brick_of[(static_cast<size_t>(corner.z()) * bricks.y() + corner.y()) * bricks.x() +
                     corner.x()] = 1;
    return 1;
  }
  size_t count = 0;
  for (int i = 0; i < 8 && count <= most; ++i)
    count += mark(faces, origin, side, reach,
                  corner + size / 2 * Eigen::Vector3i(i & 1, i >> 1 & 1, i >> 2), size / 2,
                  most - count, layout);
  return count;
}

/// Numbers the bricks. @return false when the field would need more than `most_bytes`.
bool layOut(const ClosestFace& faces, const Eigen::Vector3d& origin, const Eigen::Vector3d& extent,
            double voxel, double reach, double most_bytes, BrickLayout* layout) {
  const double side = DistanceField::kBrick * voxel;
  double total = 1;
  for (int k = 0; k < 3; ++k) total *= std::max(1.0, std::ceil(extent[k] / side));
  if (4 * total > most_bytes) return false;
  int whole = 1;
  for (int k = 0; k < 3; ++k) {
    layout->bricks[k] = std::max(1, static_cast<int>(std::ceil(extent[k] / side)));
    while (whole < layout->bricks[k]) whole *= 2;
  }
  layout->brick_of.assign(static_cast<size_t>(total), 0);
  const auto most = static_cast<size_t>(most_bytes / (4 * DistanceField::kBrickVoxels)) - 1;
  if (mark(faces, origin, side, reach, Eigen::Vector3i::Zero(), whole, most, layout) > most)
    return false;
  layout->count = 1;
  for (int32_t& brick : layout->brick_of)
    if (brick != 0) brick = layout->count++;
  return true;
}

uint32_t packed(const Eigen::Vector3d& gradient, double distance, double step) {
  const auto steps = static_cast<uint32_t>(
      std::min<long>(std::lround(distance / step), static_cast<long>(DistanceField::kFar) - 1));
  uint32_t word = steps;
  for (int k = 0; k < 3; ++k) {
    const auto part = static_cast<int8_t>(std::lround(127 * gradient[k]));
    word |= static_cast<uint32_t>(static_cast<uint8_t>(part)) << (8 * (k + 1));
  }
  return word;
}

Eigen::Vector3d normalOf(const MeshModel& mesh, uint32_t face) {
  const auto& t = mesh.triangles[face];
  const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
  return (mesh.vertices[t[1]].cast<double>() - a)
      .cross(mesh.vertices[t[2]].cast<double>() - a)
      .normalized();
}

}  // namespace

DistanceField::DistanceField(const MeshModel& mesh, const Options& options)
    : truncation_(options.truncation) {
  if (mesh.triangles.empty())
    throw InputError("depth images need surfaces, but the model has no faces");
  const ClosestFace faces(mesh);
  voxel_size_ = options.voxel_size > 0 ? options.voxel_size : 0.04;
  BrickLayout layout;
  double reach = 0;
  for (;; voxel_size_ *= 1.25) {
    // One voxel beyond the truncation is more than half a voxel's diagonal, so every point within
    // the truncation lies in a measured voxel.
    reach = truncation_ + voxel_size_;
    origin_ = mesh.lowest.cast<double>() - Eigen::Vector3d::Constant(reach);
    const Eigen::Vector3d extent =
        (mesh.highest - mesh.lowest).cast<double>() + Eigen::Vector3d::Constant(2 * reach);
    if (layOut(faces, origin_, extent, voxel_size_, reach, options.most_bytes, &layout)) break;
    if (options.voxel_size > 0)
      throw InputError(
          "depth.voxel_size is too small for a model of this size: the field needs more than "
          "depth.field_megabytes");
  }
  std::copy_n(layout.bricks, 3, bricks_);
  brick_of_ = std::move(layout.brick_of);
  voxels_.assign(static_cast<size_t>(layout.count) * kBrickVoxels, kFar);

  const double step = distanceStep();
  const size_t nx = bricks_[0], ny = bricks_[1];
  tbb::parallel_for(size_t{0}, brick_of_.size(), [&](size_t b) {
    if (brick_of_[b] == 0) return;
    const size_t across = b / nx % ny, up = b / (nx * ny);
    const Eigen::Vector3d corner(static_cast<double>(b % nx), static_cast<double>(across),
                                 static_cast<double>(up));
    uint32_t* out = &voxels_[static_cast<size_t>(brick_of_[b]) * kBrickVoxels];
    Eigen::Vector3d last_centre = Eigen::Vector3d::Zero();
    double last_distance = INFINITY;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int x = i % kBrick, y = i / kBrick % kBrick, z = i / (kBrick * kBrick);
      const Eigen::Vector3d in_brick(x + 0.5, y + 0.5, z + 0.5);
      const Eigen::Vector3d centre = origin_ + voxel_size_ * (kBrick * corner + in_brick);
      // A search is faster when its reach is shorter. The nearest surface cannot be farther than
      // the way over the last voxel's centre. The search rounds coordinates to single precision,
      // hence the slack.
      const double slack = 1e-5 + 1e-6 * centre.cwiseAbs().maxCoeff();
      const double bound = last_distance + (centre - last_centre).norm() + slack;
      ClosestFace::Hit hit = faces.find(centre, std::min(reach, bound));
      if (!hit.found && bound < reach) hit = faces.find(centre, reach);
      if (!hit.found) continue;
      last_centre = centre;
      last_distance = hit.distance;
      const Eigen::Vector3d away = hit.distance > 1e-6
                                       ? Eigen::Vector3d((centre - hit.point) / hit.distance)
                                       : normalOf(mesh, hit.face);
      out[i] = packed(away, hit.distance, step);
    }
  });
}

DistanceField::Reading DistanceField::at(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d in_voxels = (point - origin_) / voxel_size_;
  int cell[3];
  for (int k = 0; k < 3; ++k) {
    // The comparison is false for NaN, too.
    if (!(in_voxels[k] >= 0 && in_voxels[k] < static_cast<double>(bricks_[k]) * kBrick)) return {};
    cell[k] = static_cast<int>(in_voxels[k]);
  }
  const size_t brick =
      (static_cast<size_t>(cell[2] / kBrick) * bricks_[1] + cell[1] / kBrick) * bricks_[0] +
      cell[0] / kBrick;
  const size_t in_brick =
      (cell[2] % kBrick * kBrick + cell[1] % kBrick) * kBrick + cell[0] % kBrick;
  const uint32_t word = voxels_[static_cast<size_t>(brick_of_[brick]) * kBrickVoxels + in_brick];
  Reading reading;
  if ((word & 255u) == kFar) return reading;
  for (int k = 0; k < 3; ++k)
    reading.gradient[k] = static_cast<int8_t>(word >> (8 * (k + 1)) & 255u) / 127.0;
  const Eigen::Vector3d from_centre(in_voxels.x() - cell[0] - 0.5, in_voxels.y() - cell[1] - 0.5,
                                    in_voxels.z() - cell[2] - 0.5);
  reading.distance =
      (word & 255u) * distanceStep() + voxel_size_ * reading.gradient.dot(from_centre);
  reading.near = true;
  return reading;
}

DistanceField::Grid DistanceField::grid() const {
  return {origin_,
          voxel_size_,
          truncation_,
          distanceStep(),
          {bricks_[0], bricks_[1], bricks_[2]},
          brick_of_.data(),
          voxels_.data()};
}

}  // namespace edge_mcl
