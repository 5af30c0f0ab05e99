/// Roll and pitch from an IMU.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Which way is up. The map's z axis is.
struct UpReading {
  Eigen::Vector3d up_base = Eigen::Vector3d::UnitZ();  ///< unit vector in the base's axes
  double sigma = 0.02;                                 ///< rad, per axis
};

/// Rotation vector, base axes: turned by it (from the right), the pose has its up where it was
/// read.
Eigen::Vector3d tiltError(const Pose& T_map_base, const Eigen::Vector3d& up_base);

/// Moves the particles' tilts towards the reading: an ensemble Kalman step with perturbed readings
/// (G. Burgers, P. van Leeuwen, G. Evensen, Monthly Weather Review 126, 1998), which weights would
/// do by leaving few particles alive. Yaw and position stay.
/// @return false when the reading is farther from the particles than both spreads explain; nothing
/// is changed then.
bool correctTilt(const UpReading& reading, const std::vector<double>& weights, RandomSource* random,
                 std::vector<Pose>* poses);

/// The same for a Gaussian: a Kalman update.
PoseGaussian correctTilt(const UpReading& reading, const PoseGaussian& pose);

}  // namespace edge_mcl
