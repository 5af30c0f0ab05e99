/// Interface between the depth likelihood and its vectorised kernel. Internal.
#pragma once

#include <cstddef>

#include "edge_mcl/core/depth/distance_field.h"

namespace edge_mcl {

/// Points as arrays, a multiple of kPadding of them.
struct DepthKernelPoints {
  size_t count;
  const float *x, *y, *z;
  const float* half_inverse_variance;
  const float* peak;  ///< of the Gaussian against clutter; 0 for padding
};

/// T_map_depth in voxels of the grid, from its origin.
struct DepthKernelPose {
  float rotation[9];  ///< row-major
  float translation[3];
};

struct DepthKernelResult {
  double score;      ///< sum over all points, padding included at log(clutter)
  double agreement;  ///< sum of the probabilities of being on the model
};

DepthKernelResult runDepthKernel(const DistanceField::Grid& grid, const DepthKernelPoints& points,
                                 const DepthKernelPose& pose, float clutter);

}  // namespace edge_mcl
