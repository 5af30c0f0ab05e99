/// Corrects roll and pitch by a reading of the up direction, for example from an IMU.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// A reading of the direction that points up. In the map, up is the z axis.
struct UpReading {
  Eigen::Vector3d up_base = Eigen::Vector3d::UnitZ();  ///< up, unit vector in the axes of the base
  double sigma = 0.02;                                 ///< standard deviation per axis, rad
};

/// The rotation that brings the up direction of a pose to the reading: R_map_base * exp(result).
/// @param up_base the reading, in the axes of the base.
/// @return rotation vector in the axes of the base, rad, perpendicular to `up_base`.
Eigen::Vector3d tiltError(const Pose& T_map_base, const Eigen::Vector3d& up_base);

/// The rotations that a reading measures: about two axes perpendicular to the vertical, base frame.
Eigen::Matrix<double, 6, 2> tiltAxes(const UpReading& reading);

/// Moves the tilts of the particles towards the reading: an ensemble Kalman step with perturbed
/// readings (G. Burgers, P. van Leeuwen, G. Evensen, Monthly Weather Review 126, 1998). Weights
/// instead of this step would leave few particles alive. Heading and position do not change.
/// @param weights of the particles, with any positive sum. @param poses T_map_base.
/// @return false when the mean tilt error is larger than five standard deviations of particles and
/// reading together. Then nothing changes.
bool correctTilt(const UpReading& reading, const std::vector<double>& weights, RandomSource* random,
                 std::vector<Pose>* poses);

/// Corrects the roll and pitch of a Gaussian (T_map_base) by a Kalman update. Other coordinates
/// change as far as they are correlated with roll and pitch.
PoseGaussian correctTilt(const UpReading& reading, const PoseGaussian& pose);

}  // namespace edge_mcl
