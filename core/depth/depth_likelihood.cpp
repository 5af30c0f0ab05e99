#include "edge_mcl/core/depth/depth_likelihood.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/depth/depth_kernel.h"

namespace edge_mcl {

namespace {

/// Height of the Gaussian relative to clutter that is spread over the truncation.
double peakOf(const DepthParameters& p, double inverse_variance) {
  return (1 - p.clutter) * p.truncation * std::sqrt(2 / M_PI * inverse_variance);
}

}  // namespace

DepthLikelihood::DepthLikelihood(std::shared_ptr<const DistanceField> field,
                                 const DepthParameters& params)
    : field_(std::move(field)), params_(params) {}

double DepthLikelihood::weightOf(const DepthPoints& points) const {
  return points.count == 0
             ? 0
             : params_.independent_points * points.returned / static_cast<double>(points.count);
}

std::vector<DepthScore> DepthLikelihood::evaluate(const DepthPoints& points,
                                                  const std::vector<Pose>& camera_poses) const {
  std::vector<DepthScore> scores(camera_poses.size());
  for (size_t i = 0; i < camera_poses.size(); ++i)
    if (!isValid(camera_poses[i]))
      throw Error("depth likelihood: pose " + std::to_string(i) +
                  " is not finite or its rotation is not orthonormal");
  if (points.count == 0) return scores;
  const size_t padded = points.x.size();
  std::vector<float> half(padded, 0), peak(padded, 0);
  for (size_t i = 0; i < points.count; ++i) {
    half[i] = points.inverse_variance[i] / 2;
    peak[i] = static_cast<float>(peakOf(params_, points.inverse_variance[i]));
  }
  const DepthKernelPoints arrays{padded,          points.x.data(), points.y.data(),
                                 points.z.data(), half.data(),     peak.data()};
  const DistanceField::Grid grid = field_->grid();
  const auto clutter = static_cast<float>(params_.clutter);
  const double of_padding = static_cast<double>(padded - points.count) * std::log(params_.clutter);
  const double weight = weightOf(points);
  const auto score = [&](size_t i) {
    const Pose& pose = camera_poses[i];
    DepthKernelPose in_voxels{};
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        in_voxels.rotation[3 * row + column] =
            static_cast<float>(pose.linear()(row, column) / grid.voxel_size);
      in_voxels.translation[row] =
          static_cast<float>((pose.translation()[row] - grid.origin[row]) / grid.voxel_size);
    }
    const DepthKernelResult sums = runDepthKernel(grid, arrays, in_voxels, clutter);
    scores[i].log_likelihood = weight * (sums.score - of_padding);
    scores[i].agreement = static_cast<float>(sums.agreement / static_cast<double>(points.count));
  };
  constexpr size_t kPoses = 16;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, camera_poses.size(), kPoses),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t i = range.begin(); i < range.end(); ++i) score(i);
                    });
  return scores;
}

DepthScore DepthLikelihood::evaluateSlowly(const DepthPoints& points,
                                           const Pose& camera_pose) const {
  DepthScore score;
  double agreement = 0;
  for (size_t i = 0; i < points.count; ++i) {
    const double inverse_variance = points.inverse_variance[i];
    const DistanceField::Reading reading =
        field_->at(camera_pose * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]));
    double on_model = 0;
    if (reading.near)
      on_model = peakOf(params_, inverse_variance) *
                 std::exp(-reading.distance * reading.distance * inverse_variance / 2);
    score.log_likelihood += std::log(params_.clutter + on_model);
    agreement += on_model / (params_.clutter + on_model);
  }
  if (points.count == 0) return score;
  score.log_likelihood *= weightOf(points);
  score.agreement = static_cast<float>(agreement / static_cast<double>(points.count));
  return score;
}

/// Normal equations of the pose, with one more row and column for the bias.
struct DepthLikelihood::WithBias {
  NormalEquations pose;
  Twist mixed = Twist::Zero();  // mixed second derivative of pose and bias
  double h = 0, g = 0;          // second derivative and gradient of the bias
};

DepthLikelihood::WithBias DepthLikelihood::linearizeWithBias(const DepthPoints& points,
                                                             const Pose& camera_pose,
                                                             double least_sigma) const {
  WithBias sum;
  sum.pose.used_points = static_cast<int>(points.count);
  for (size_t i = 0; i < points.count; ++i) {
    const Eigen::Vector3d p(points.x[i], points.y[i], points.z[i]);
    const DistanceField::Reading reading = field_->at(camera_pose * p);
    if (!reading.near) continue;
    // The bias is an unknown of its own here, so it is no part of the noise.
    const double inverse_variance =
        std::min<double>(points.inverse_noise[i], 1 / std::max(1e-12, least_sigma * least_sigma));
    const double on_model = peakOf(params_, inverse_variance) *
                            std::exp(-reading.distance * reading.distance * inverse_variance / 2);
    const double belief = on_model / (params_.clutter + on_model);
    if (belief > 0.5) ++sum.pose.matched_points;
    // A change (v, w) of the pose moves a point that is fixed to the camera by v + w x p in camera
    // axes. A change of the bias by one unit moves it by z p.
    const Eigen::Vector3d gradient = camera_pose.linear().transpose() * reading.gradient;
    Twist row;
    row << gradient, p.cross(gradient);
    const double by_bias = p.z() * gradient.dot(p);
    const double weight = belief * inverse_variance;
    sum.pose.h.noalias() += (weight * row) * row.transpose();
    sum.pose.g -= weight * reading.distance * row;
    sum.mixed += weight * by_bias * row;
    sum.h += weight * by_bias * by_bias;
    sum.g -= weight * by_bias * reading.distance;
  }
  const double share = weightOf(points);
  sum.pose.h *= share;
  sum.pose.g *= share;
  sum.mixed *= share;
  sum.h *= share;
  sum.g *= share;
  if (points.bias_variance > 0) sum.h += 1 / points.bias_variance;
  return sum;
}

NormalEquations DepthLikelihood::linearize(const DepthPoints& points, const Pose& camera_pose,
                                           double least_sigma) const {
  WithBias sum = linearizeWithBias(points, camera_pose, least_sigma);
  if (points.bias_variance > 0) {
    sum.pose.h -= sum.mixed * sum.mixed.transpose() / sum.h;
    sum.pose.g -= sum.mixed * (sum.g / sum.h);
  }
  return sum.pose;
}

DepthBias DepthLikelihood::remainingBias(const DepthPoints& points, const Pose& camera_pose,
                                         const Matrix6& camera_covariance) const {
  if (!(points.bias_variance > 0)) return {};
  const WithBias sum = linearizeWithBias(points, camera_pose, 0);
  const Twist slope = sum.mixed / sum.h;
  // The variance is that at a given pose plus the part that the uncertainty of the pose adds.
  return {sum.g / sum.h, 1 / sum.h + slope.dot(camera_covariance * slope)};
}

}  // namespace edge_mcl
