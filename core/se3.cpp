#include "edge_mcl/core/se3.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/error.h"

namespace edge_mcl {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d expSo3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const Eigen::Matrix3d s = skew(rotation_vector);
  if (angle < 1e-8) return Eigen::Matrix3d::Identity() + s + 0.5 * s * s;
  return Eigen::Matrix3d::Identity() + std::sin(angle) / angle * s +
         (1 - std::cos(angle)) / (angle * angle) * s * s;
}

Eigen::Vector3d logSo3(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() *= -1;
  const double sine = q.vec().norm();
  if (sine < 1e-10) return 2 * q.vec();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

namespace {

/// Left Jacobian of SO(3), the "V" matrix of the SE(3) exponential.
Eigen::Matrix3d leftJacobian(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const Eigen::Matrix3d s = skew(rotation_vector);
  if (angle < 1e-6) return Eigen::Matrix3d::Identity() + 0.5 * s + s * s / 6;
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / a2 * s +
         (angle - std::sin(angle)) / (a2 * angle) * s * s;
}

}  // namespace

Pose expSe3(const Twist& xi) {
  Pose pose = Pose::Identity();
  pose.linear() = expSo3(xi.tail<3>());
  pose.translation() = leftJacobian(xi.tail<3>()) * xi.head<3>();
  return pose;
}

Twist logSe3(const Pose& pose) {
  Twist xi;
  xi.tail<3>() = logSo3(pose.linear());
  xi.head<3>() = leftJacobian(xi.tail<3>()).inverse() * pose.translation();
  return xi;
}

Matrix6 adjoint(const Pose& pose) {
  Matrix6 adjoint = Matrix6::Zero();
  adjoint.topLeftCorner<3, 3>() = pose.linear();
  adjoint.bottomRightCorner<3, 3>() = pose.linear();
  adjoint.topRightCorner<3, 3>() = skew(pose.translation()) * pose.linear();
  return adjoint;
}

bool isValid(const Pose& pose) {
  if (!pose.matrix().allFinite()) return false;
  const Eigen::Matrix3d r = pose.linear();
  return (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6 &&
         r.determinant() > 0;
}

Pose normalized(const Pose& pose) {
  Pose result = pose;
  result.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  return result;
}

double rotationAngle(const Pose& a, const Pose& b) {
  return logSo3(a.linear().transpose() * b.linear()).norm();
}

PoseGaussian meanAndCovariance(const std::vector<Pose>& poses, const std::vector<double>& weights) {
  if (poses.empty() || poses.size() != weights.size())
    throw Error("mean of poses: no poses, or a different number of weights");
  double sum = 0;
  size_t heaviest = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    if (weights[i] > weights[heaviest]) heaviest = i;
  }
  if (!(sum > 0) || !std::isfinite(sum)) throw Error("mean of poses: the weights sum to nothing");

  PoseGaussian result;
  result.mean = poses[heaviest];
  for (int iteration = 0; iteration < 20; ++iteration) {
    Twist step = Twist::Zero();
    const Pose inverse = result.mean.inverse();
    for (size_t i = 0; i < poses.size(); ++i)
      if (weights[i] > 0) step += weights[i] / sum * logSe3(inverse * poses[i]);
    result.mean = normalized(result.mean * expSe3(step));
    if (step.norm() < 1e-10) break;
  }
  const Pose inverse = result.mean.inverse();
  for (size_t i = 0; i < poses.size(); ++i) {
    if (weights[i] <= 0) continue;
    const Twist xi = logSe3(inverse * poses[i]);
    result.covariance += weights[i] / sum * xi * xi.transpose();
  }
  return result;
}

namespace {

Matrix6 blockRotation(const Eigen::Matrix3d& r) {
  Matrix6 m = Matrix6::Zero();
  m.topLeftCorner<3, 3>() = r;
  m.bottomRightCorner<3, 3>() = r;
  return m;
}

}  // namespace

Matrix6 covarianceInMapAxes(const PoseGaussian& gaussian) {
  // To first order T*exp(xi) moves the origin by R*v and turns it by R*w seen from the map.
  const Matrix6 m = blockRotation(gaussian.mean.linear());
  return m * gaussian.covariance * m.transpose();
}

Matrix6 covarianceFromMapAxes(const Pose& mean, const Matrix6& covariance_map_axes) {
  const Matrix6 m = blockRotation(mean.linear().transpose());
  return m * covariance_map_axes * m.transpose();
}

}  // namespace edge_mcl
