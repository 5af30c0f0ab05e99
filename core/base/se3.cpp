#include "edge_mcl/core/base/se3.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"

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
  Eigen::Quaterniond q(pose.linear());
  if (q.w() < 0) q.coeffs() *= -1;
  const double sine = q.vec().norm();
  const double angle = 2 * std::atan2(sine, q.w());
  const Eigen::Vector3d w = (sine < 1e-10 ? 2.0 : angle / sine) * q.vec();
  // Inverse of the left Jacobian, I - S/2 + (1 - a/2 cot(a/2)) / a^2 S^2 (e.g. T. Barfoot, "State
  // Estimation for Robotics", 7.1.3).
  const double factor =
      angle < 1e-4 ? 1.0 / 12 : (1 - 0.5 * angle * q.w() / sine) / (angle * angle);
  const Eigen::Vector3d t = pose.translation(), wt = w.cross(t);
  Twist xi;
  xi << t - 0.5 * wt + factor * w.cross(wt), w;
  return xi;
}

Matrix6 adjoint(const Pose& pose) {
  Matrix6 adjoint = Matrix6::Zero();
  adjoint.topLeftCorner<3, 3>() = pose.linear();
  adjoint.bottomRightCorner<3, 3>() = pose.linear();
  adjoint.topRightCorner<3, 3>() = skew(pose.translation()) * pose.linear();
  return adjoint;
}

Eigen::Matrix3d rotationFromAngles(double roll, double pitch, double yaw) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

bool isOnEarth(const Eigen::Vector3d& position) {
  constexpr double kFarthest = 1e8;  // m; the circumference of the earth is 4e7 m
  return position.allFinite() && position.cwiseAbs().maxCoeff() <= kFarthest;
}

bool isValid(const Pose& pose) {
  if (!pose.matrix().allFinite() || !isOnEarth(pose.translation())) return false;
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

Matrix6 inverseOf(const Matrix6& symmetric) { return symmetric.ldlt().solve(Matrix6::Identity()); }

Matrix6 excessOver(const Matrix6& narrow, const Matrix6& wide) {
  constexpr double kLeast = 1e-12;  // m^2 and rad^2, so that the covariance can be inverted
  const Matrix6 factor =
      Eigen::LLT<Matrix6>(narrow + kLeast * Matrix6::Identity()).matrixL().toDenseMatrix();
  const Matrix6 inverse = factor.triangularView<Eigen::Lower>().solve(Matrix6::Identity().eval());
  // In these axes `narrow` is the identity.
  const Eigen::SelfAdjointEigenSolver<Matrix6> axes(inverse * wide * inverse.transpose());
  const Matrix6 directions = factor * axes.eigenvectors();
  const Vector6 excess = (axes.eigenvalues().array() - 1).max(0);
  const Matrix6 result = directions * excess.asDiagonal() * directions.transpose();
  // A `narrow` that is no covariance has no factor.
  return result.allFinite() ? result : Matrix6::Zero().eval();
}

Twist solve(const Matrix6& symmetric, const Twist& right) { return symmetric.ldlt().solve(right); }

double squaredMahalanobis(const Twist& offset, const Matrix6& covariance) {
  return offset.dot(covariance.ldlt().solve(offset));
}

PoseGaussian meanAndCovariance(const std::vector<Pose>& poses, const std::vector<double>& weights) {
  if (poses.empty() || poses.size() != weights.size())
    throw Error("mean of poses: there are no poses, or the number of weights differs");
  double sum = 0;
  size_t heaviest = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    if (weights[i] > weights[heaviest]) heaviest = i;
  }
  if (!(sum > 0) || !std::isfinite(sum))
    throw Error("mean of poses: the sum of the weights is not positive and finite");

  // Moments about a guess of the mean. Pieces of fixed size give the same bits for any number of
  // threads.
  struct Moments {
    Twist first = Twist::Zero();
    Matrix6 second = Matrix6::Zero();
  };
  constexpr size_t kPiece = 256;
  std::vector<Moments> pieces((poses.size() + kPiece - 1) / kPiece);
  const auto momentsAbout = [&](const Pose& guess) {
    const Pose inverse = guess.inverse();
    tbb::parallel_for(size_t{0}, pieces.size(), [&](size_t p) {
      Moments m;
      for (size_t i = p * kPiece; i < std::min(poses.size(), (p + 1) * kPiece); ++i) {
        if (weights[i] <= 0) continue;
        const Twist xi = logSe3(inverse * poses[i]);
        m.first += weights[i] / sum * xi;
        m.second.noalias() += (weights[i] / sum * xi) * xi.transpose();
      }
      pieces[p] = m;
    });
    Moments total;
    for (const Moments& m : pieces) {
      total.first += m.first;
      total.second += m.second;
    }
    return total;
  };
  PoseGaussian result;
  result.mean = poses[heaviest];
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Moments moments = momentsAbout(result.mean);
    result.covariance = moments.second;
    if (moments.first.norm() < 1e-9) break;  // less than a nanometre: this guess is the mean
    result.mean = normalized(result.mean * expSe3(moments.first));
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
  // To first order T*exp(xi) moves the origin by R*v and turns it by R*w, both in map axes.
  const Matrix6 m = blockRotation(gaussian.mean.linear());
  return m * gaussian.covariance * m.transpose();
}

Matrix6 covarianceFromMapAxes(const Pose& mean, const Matrix6& covariance_map_axes) {
  const Matrix6 m = blockRotation(mean.linear().transpose());
  return m * covariance_map_axes * m.transpose();
}

Pose opticalOnBody() {
  Pose pose = Pose::Identity();
  pose.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return pose;
}

}  // namespace edge_mcl
