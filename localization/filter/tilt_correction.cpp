#include "edge_mcl/localization/filter/tilt_correction.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

namespace edge_mcl {

Eigen::Vector3d tiltError(const Pose& T_map_base, const Eigen::Vector3d& up_base) {
  const Eigen::Vector3d predicted = T_map_base.linear().transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d axis = up_base.cross(predicted);
  const double sine = axis.norm(), angle = std::atan2(sine, up_base.dot(predicted));
  if (sine > 1e-12) return angle / sine * axis;
  // The pose agrees with the reading, or it is upside down. If it is upside down, every horizontal
  // axis is right.
  return angle < 1 ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                   : Eigen::Vector3d(angle * up_base.unitOrthogonal());
}

bool correctTilt(const UpReading& reading, const std::vector<double>& weights, RandomSource* random,
                 std::vector<Pose>* poses) {
  const Eigen::Vector3d up = reading.up_base.normalized();
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<Eigen::Vector3d> errors;
  errors.reserve(poses->size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < poses->size(); ++i) {
    errors.push_back(tiltError((*poses)[i], up));
    mean += weights[i] / total * errors.back();
  }
  double spread = 0;  // variance per axis; a tilt has two axes
  for (size_t i = 0; i < poses->size(); ++i)
    spread += weights[i] / total * (errors[i] - mean).squaredNorm() / 2;
  const double noise = reading.sigma * reading.sigma;
  constexpr double kFarthest = 5;  // largest mean error, in standard deviations
  if (mean.squaredNorm() > kFarthest * kFarthest * (spread + noise)) return false;
  const double gain = spread / (spread + noise);
  for (size_t i = 0; i < poses->size(); ++i) {
    const Eigen::Vector3d perturbation =
        reading.sigma * up.cross(Eigen::Vector3d(random->normalTwist().head<3>()));
    Pose& pose = (*poses)[i];
    pose.linear() = pose.linear() * expSo3(gain * (errors[i] + perturbation));
    pose = normalized(pose);
  }
  return true;
}

Eigen::Matrix<double, 6, 2> tiltAxes(const UpReading& reading) {
  const Eigen::Vector3d up = reading.up_base.normalized();
  Eigen::Matrix<double, 6, 2> axes = Eigen::Matrix<double, 6, 2>::Zero();
  axes.col(0).tail<3>() = up.unitOrthogonal();
  axes.col(1).tail<3>() = up.cross(up.unitOrthogonal());
  return axes;
}

PoseGaussian correctTilt(const UpReading& reading, const PoseGaussian& pose) {
  const Eigen::Vector3d up = reading.up_base.normalized();
  const Eigen::Matrix<double, 6, 2> read = tiltAxes(reading);
  const Eigen::Matrix2d innovation = read.transpose() * pose.covariance * read +
                                     reading.sigma * reading.sigma * Eigen::Matrix2d::Identity();
  const Eigen::Matrix<double, 6, 2> gain =
      pose.covariance * read * innovation.ldlt().solve(Eigen::Matrix2d::Identity());
  PoseGaussian result;
  const Eigen::Vector2d error = read.bottomRows<3>().transpose() * tiltError(pose.mean, up);
  result.mean = normalized(pose.mean * expSe3(gain * error));
  result.covariance = pose.covariance - gain * read.transpose() * pose.covariance;
  return result;
}

}  // namespace edge_mcl
