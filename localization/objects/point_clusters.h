/// Groups points of things that are not in the model: one cluster for each thing.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <utility>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// Edge of a voxel, m. Neighbouring points of a depth camera that sees 160 of them side by side lie
/// this far apart at 10 m.
constexpr double kObjectVoxel = 0.1;

/// All points in one voxel.
struct VoxelPoint {
  int64_t key = 0;        ///< equal for all points in the voxel
  Eigen::Vector3f point;  ///< their mean, map frame, m
  int count = 0;          ///< number of the points
  int inner = 0;          ///< number of those with neighbours on all four sides in the image
};

/// One thing in one depth image.
using PointCluster = std::vector<VoxelPoint>;

/// Points that are joined to voxels.
struct Voxels {
  std::vector<VoxelPoint> list;    ///< in the order of their keys
  std::vector<uint32_t> of_point;  ///< index into `list` for every point; kNone: left out
  static constexpr uint32_t kNone = UINT32_MAX;
};

/// Joins points that share a voxel. @param points map frame, m; those farther than 50 km from the
/// origin are left out.
Voxels voxelsOf(const std::vector<Eigen::Vector3f>& points);

/// Indices of two points that surely belong to one thing.
using PointPair = std::pair<uint32_t, uint32_t>;

/// Finds points that are neighbours in a depth image and differ little in depth. A surface that is
/// seen at a flat angle has few points, and only here they hang together.
/// @param points frame of the depth camera, m. @param spacing of neighbours in the image, pixels
std::vector<PointPair> neighboursOf(const std::vector<Eigen::Vector3f>& points,
                                    const CameraModel& camera, double spacing);

/// Joins voxels to things. Neighbours side by side touch. Upwards there may be gaps of 0.4 m: seat
/// and back of a chair belong together, and depth is often missing between them.
/// @param pairs of points that are joined as well. @return in the order of their first voxels.
std::vector<PointCluster> clustersOf(const Voxels& voxels, const std::vector<PointPair>& pairs);

/// Smallest box in the axes of the map around a cluster. Of a thousand points at least the 990 in
/// the middle of every axis lie in it: single wrong depths do not make a thing larger.
Eigen::AlignedBox3d boxOf(const PointCluster& cluster);

/// Number of the points in a cluster, and of those with neighbours on all four sides. A cluster
/// that is one or two pixels wide has none of these.
int pointsIn(const PointCluster& cluster);
int innerPointsIn(const PointCluster& cluster);

/// Whether a cluster can be a thing of its own: it has 20 inner points, and a side of 0.15 m.
/// Smaller and thinner ones are the edges of surfaces.
bool isLarge(const PointCluster& cluster);

/// Both clusters as one. They have no voxel in common.
PointCluster joined(PointCluster a, const PointCluster& b);

}  // namespace edge_mcl
