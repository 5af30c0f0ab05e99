/// Finds how two systems of coordinates lie to each other, from poses that are known in both.
#pragma once

#include <utility>
#include <vector>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// One pose in both systems.
struct PosePair {
  Pose from = Pose::Identity(), to = Pose::Identity();
};

/// Rotation, shift and scale: to = scale * (rotation * from) + shift.
struct Similarity {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< m
  double scale = 1;

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return scale * (rotation * point) + shift;
  }
};

/// A similarity and how well it is known.
struct SimilarityFit {
  Similarity similarity;
  size_t used = 0;            ///< pairs that agree with it
  double position_rms = 0;    ///< m, of these pairs
  double rotation_rms = 0;    ///< rad, of these pairs
  double position_sigma = 0;  ///< standard deviation of the shift in the middle of the pairs, m
  double rotation_sigma = 0;  ///< rad
  double scale_sigma = 0;
  /// Angle between the rotation that the orientations tell and the one that the positions tell,
  /// rad; 0 when the positions lie on a line. A large one means that the poses are of different
  /// bodies.
  double disagreement = 0;
};

/// Fits a similarity. The rotation is the mean of the orientations' differences, since the
/// positions of a flight may lie on a line. Shift and scale are those of least squares. Pairs
/// farther off than three times the median are left out.
/// @param scale_is_known the scale is 1.
/// @throws InputError when there are fewer than ten pairs, or when they do not move by 0.3 m and
/// the
///   scale is wanted
SimilarityFit fitSimilarity(const std::vector<PosePair>& pairs, bool scale_is_known);

}  // namespace edge_mcl
