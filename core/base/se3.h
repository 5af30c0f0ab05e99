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

/// Rigid-body pose, metres.
using Pose = Eigen::Isometry3d;
/// Tangent vector of SE(3): metres, radians.
using Twist = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Six numbers for the axes of a tangent vector that are no tangent vector themselves: standard
/// deviations (m, rad) or variances.
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Matrix of the cross product: skew(v) * u = v x u.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);
/// Rotation matrix of a rotation vector, radians.
Eigen::Matrix3d expSo3(const Eigen::Vector3d& rotation_vector);
/// Rotation vector of a rotation matrix, radians. Its length is at most pi.
Eigen::Vector3d logSo3(const Eigen::Matrix3d& rotation);
/// Pose of a tangent vector.
Pose expSe3(const Twist& xi);
/// Tangent vector of a pose, the inverse of expSe3().
Twist logSe3(const Pose& pose);
/// Adjoint of a pose: `T * exp(xi) == exp(adjoint(T) * xi) * T`.
Matrix6 adjoint(const Pose& pose);

/// Rotation about the fixed axes x, y, z in this order (REP 103), radians.
Eigen::Matrix3d rotationFromAngles(double roll, double pitch, double yaw);

/// Whether a position (m) is finite and at most 1e8 m from the origin along each axis. All
/// coordinates in use on earth are smaller, and libraries of rays end the process far beyond.
bool isOnEarth(const Eigen::Vector3d& position);
/// Whether the position of a pose isOnEarth() and its rotation is finite, right-handed and
/// orthonormal to 1e-6.
bool isValid(const Pose& pose);
/// Makes the rotation part orthonormal again, after many compositions.
Pose normalized(const Pose& pose);
/// Angle of the relative rotation between two poses, radians.
double rotationAngle(const Pose& a, const Pose& b);

/// Gaussian on SE(3): `mean * exp(xi)` with xi ~ N(0, covariance).
struct PoseGaussian {
  Pose mean = Pose::Identity();
  Matrix6 covariance = Matrix6::Zero();
};

/// Inverse of a covariance or information matrix, by Cholesky decomposition.
Matrix6 inverseOf(const Matrix6& symmetric);
/// Solves `symmetric * x = right` by Cholesky decomposition.
Twist solve(const Matrix6& symmetric, const Twist& right);
/// What a covariance lacks in those directions in which another one is wider. The sum of `narrow`
/// and the result is at least `narrow` and at least `wide` in every direction.
Matrix6 excessOver(const Matrix6& narrow, const Matrix6& wide);
/// Squared Mahalanobis distance: offset^T covariance^-1 offset.
double squaredMahalanobis(const Twist& offset, const Matrix6& covariance);

/// Weighted intrinsic mean of poses, and their covariance in the tangent space at the mean. The
/// mean is the fixed point of `mean * exp(sum w_i log(mean^-1 T_i))`. The iteration starts at the
/// pose with the largest weight.
/// @param weights one for every pose, non-negative, with any positive sum.
/// @throws Error when there are no poses, the number of weights differs, or their sum is not
///   positive and finite.
PoseGaussian meanAndCovariance(const std::vector<Pose>& poses, const std::vector<double>& weights);

/// Covariance of a Gaussian for (x, y, z, rotation vector) in map axes: translation is added in the
/// map, and rotation is multiplied from the left. This is the order and the frame of a ROS
/// PoseWithCovariance (fixed-axis rotations, first order).
Matrix6 covarianceInMapAxes(const PoseGaussian& gaussian);
/// Inverse of covarianceInMapAxes().
Matrix6 covarianceFromMapAxes(const Pose& mean, const Matrix6& covariance_map_axes);

/// Pose of an optical frame that looks forward (x right, y down, z forward), on a base with x
/// forward, y left, z up (REP 103).
Pose opticalOnBody();

}  // namespace edge_mcl
