/// Rigid-body poses and their statistics.
///
/// A pose `T_a_b` maps coordinates of frame b into frame a. Tangent vectors are ordered
/// (translation, rotation) and live in the moving (right) frame: `T * exp(xi)`.
/// Formulas: J. Sola, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in
/// robotics", arXiv:1812.01537, section V and appendix D.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace edge_mcl {

using Pose = Eigen::Isometry3d;
/// Tangent vector of SE(3): metres, radians.
using Twist = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Eigen::Matrix3d skew(const Eigen::Vector3d& v);
Eigen::Matrix3d expSo3(const Eigen::Vector3d& rotation_vector);
/// Rotation vector of length at most pi.
Eigen::Vector3d logSo3(const Eigen::Matrix3d& rotation);
Pose expSe3(const Twist& xi);
Twist logSe3(const Pose& pose);
/// Adjoint: `T * exp(xi) == exp(adjoint(T) * xi) * T`.
Matrix6 adjoint(const Pose& pose);

/// Rotation about the fixed axes x, y, z in this order (REP 103), radians.
Eigen::Matrix3d rotationFromAngles(double roll, double pitch, double yaw);

/// False when any entry is not finite or the rotation is not orthonormal to 1e-6.
bool isValid(const Pose& pose);
/// Puts the rotation part back onto SO(3) after many compositions.
Pose normalized(const Pose& pose);
/// Angle of the relative rotation, radians.
double rotationAngle(const Pose& a, const Pose& b);

/// Gaussian on SE(3): `mean * exp(xi)`, xi ~ N(0, covariance).
struct PoseGaussian {
  Pose mean = Pose::Identity();
  Matrix6 covariance = Matrix6::Zero();
};

/// Weighted intrinsic mean (fixed point of `mean * exp(sum w_i log(mean^-1 T_i))`) and covariance
/// in the tangent space at the mean. The start is the heaviest pose.
/// @param weights non-negative, any positive sum. @throws Error on empty input or zero sum.
PoseGaussian meanAndCovariance(const std::vector<Pose>& poses, const std::vector<double>& weights);

/// The same Gaussian as mean and covariance of (x, y, z, rotation vector) in map axes:
/// translation added in the map, rotation multiplied from the left. This is the order and the
/// frame of a ROS PoseWithCovariance (fixed-axis rotations, first order).
Matrix6 covarianceInMapAxes(const PoseGaussian& gaussian);
/// Inverse of covarianceInMapAxes.
Matrix6 covarianceFromMapAxes(const Pose& mean, const Matrix6& covariance_map_axes);

/// The optical frame (x right, y down, z forward) on a robot whose base has x forward, y left, z up
/// (REP 103).
Pose opticalOnBody();

}  // namespace edge_mcl
