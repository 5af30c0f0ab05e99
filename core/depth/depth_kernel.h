/// Interface between the depth likelihood and its vectorised kernel. Internal.
#pragma once

#include <cstddef>

#include "edge_mcl/core/depth/distance_field.h"

namespace edge_mcl {

/// Depth points as arrays of `count` elements, a multiple of DepthPoints::kPadding.
struct DepthKernelPoints {
  size_t count;
  const float *x, *y, *z;              ///< depth camera's optical frame, metres
  const float* half_inverse_variance;  ///< 1 / (2 sigma^2) of the distance, 1/m^2; 0 for padding
  const float* peak;  ///< height of the Gaussian relative to clutter; 0 for padding
};

/// Maps points of the depth camera (metres) to voxels of the grid, counted from its origin. It is
/// T_map_depth moved to the origin and divided by the voxel size.
struct DepthKernelPose {
  float rotation[9];  ///< row-major
  float translation[3];
};

/// Sums over all points for one pose.
struct DepthKernelResult {
  double score;      ///< sum of log(clutter + Gaussian); every padding point adds log(clutter)
  double agreement;  ///< sum of the probabilities that a point is on the model
};

/// Scores all points for one pose. @param clutter share of clutter (`depth.clutter`).
DepthKernelResult runDepthKernel(const DistanceField::Grid& grid, const DepthKernelPoints& points,
                                 const DepthKernelPose& pose, float clutter);

}  // namespace edge_mcl
