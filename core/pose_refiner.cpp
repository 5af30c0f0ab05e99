#include "edge_mcl/core/pose_refiner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "edge_mcl/core/edge_field.h"

namespace edge_mcl {

bool pixelJacobian(const CameraModel& camera, const Eigen::Vector3d& point_camera,
                   Eigen::Vector2d* pixel, Eigen::Matrix<double, 2, 6>* jacobian) {
  Eigen::Matrix<double, 2, 3> projection;
  if (!camera.project(point_camera, pixel, &projection)) return false;
  // exp(-xi) p = p - v + p x w + ...
  jacobian->leftCols<3>() = -projection;
  jacobian->rightCols<3>() = projection * skew(point_camera);
  return true;
}

struct PoseRefiner::NormalEquations {
  Matrix6 h = Matrix6::Zero();
  Twist g = Twist::Zero();
  int matched = 0, used = 0;
};

namespace {

/// Number of samples inside the image, estimated from the middles of the segments.
size_t inImage(const RefinementView& view, const Pose& pose) {
  const Pose camera_from_map = pose.inverse();
  size_t count = 0;
  for (const VisibleSet::Segment& segment : view.visible->segments) {
    Eigen::Vector2d pixel;
    const EdgeSegment& edge = view.visible->edgeSegment(segment);
    if (view.camera->project(camera_from_map * edge.centre.cast<double>(), &pixel) &&
        view.camera->contains(pixel))
      count += edge.sample_count;
  }
  return count;
}

}  // namespace

PoseRefiner::PoseRefiner(RefinementParameters refinement, LikelihoodParameters likelihood,
                         ImageParameters image)
    : refinement_(refinement), likelihood_(likelihood), image_(image) {}

PoseRefiner::NormalEquations PoseRefiner::linearize(const RefinementView& view,
                                                    const Pose& base_pose, double search_length,
                                                    double sigma,
                                                    const Matrix6* prior_covariance) const {
  const CameraModel& camera = *view.camera;
  const EdgeImage& image = *view.image;
  const VisibleSet& set = *view.visible;
  const Pose pose = base_pose * view.T_base_camera;
  NormalEquations total, line;
  const uint32_t stride = std::max<uint32_t>(
      1, static_cast<uint32_t>(inImage(view, pose) / static_cast<size_t>(refinement_.max_samples)));
  uint32_t phase = 0;
  const Pose camera_from_map = pose.inverse();
  // The camera moves with the base: xi_camera = Ad(T_camera_base) xi_base.
  const Matrix6 to_base = adjoint(view.T_base_camera.inverse());
  Matrix6 camera_covariance = Matrix6::Zero();
  if (prior_covariance) camera_covariance = to_base * *prior_covariance * to_base.transpose();
  const double tolerance_cos = std::cos(image_.orientation_tolerance_deg * M_PI / 180);
  const double e = likelihood_.missing_edge;
  const double clutter_density = e / (2 * search_length);
  const double peak = (1 - e) / (std::sqrt(2 * M_PI) * sigma);
  for (size_t k = 0; k < set.segments.size(); ++k) {
    const VisibleSet::Segment& segment = set.segments[k];
    const EdgeSegment& edge = set.edgeSegment(segment);
    const Eigen::Vector3d tangent =
        camera_from_map.linear() * set.line(segment).tangent().cast<double>();
    for (uint32_t i = 0; i < edge.sample_count; ++i) {
      if (!(segment.samples >> i & 1u) || phase++ % stride != 0) continue;
      const Eigen::Vector3d p = camera_from_map * set.model->samplePosition(edge, i);
      Eigen::Vector2d pixel;
      if (!camera.project(p, &pixel) || !camera.contains(pixel)) continue;
      const int x = static_cast<int>(std::lround(pixel.x()));
      const int y = static_cast<int>(std::lround(pixel.y()));
      if (!image.ignore.empty() && image.ignore.at<uint8_t>(y, x)) continue;
      Eigen::Matrix<double, 2, 6> jacobian;
      if (!pixelJacobian(camera, p, &pixel, &jacobian)) continue;
      // The first three columns are minus the projection's Jacobian.
      const Eigen::Vector2d direction = -jacobian.leftCols<3>() * tangent;
      if (direction.norm() < 1e-6) continue;
      const Eigen::Vector2d normal = Eigen::Vector2d(-direction.y(), direction.x()).normalized();
      const Twist row = (normal.transpose() * jacobian).transpose();
      ++line.used;
      // The prior says how far along this normal the edge can be (active search).
      double length = search_length;
      if (prior_covariance) {
        const double spread = std::sqrt(row.dot(camera_covariance * row));
        length = std::min(length, std::max(refinement_.final_search_length / 2, 3 * spread + 2));
      }
      const NormalHit hit = searchAlongNormal(image, pixel, normal, length, tolerance_cos);
      if (!hit.found) continue;
      ++line.matched;
      const double residual = normal.dot(image.subPixel(hit.x, hit.y) - pixel);
      const double inlier = peak * std::exp(-residual * residual / (2 * sigma * sigma));
      const double weight =
          VisibleSet::facingWeight(segment) * inlier / (inlier + clutter_density) / (sigma * sigma);
      line.h.noalias() += weight * row * row.transpose();
      line.g += weight * residual * row;
    }
    if (!set.endsGroup(k)) continue;
    // As in the robust likelihood, one line says at most as much as `line_saturation` samples.
    const double share = stride / (1 + stride * line.used / likelihood_.line_saturation);
    total.h += share * line.h;
    total.g += share * line.g;
    total.matched += line.matched;
    total.used += line.used;
    line = {};
  }
  total.h = to_base.transpose() * total.h * to_base;
  total.g = to_base.transpose() * total.g;
  return total;
}

RefinementResult PoseRefiner::refine(const std::vector<RefinementView>& views, const Pose& start,
                                     const std::optional<PoseGaussian>& prior) const {
  RefinementResult result;
  result.pose = start;
  Matrix6 prior_information = Matrix6::Zero();
  if (prior)
    prior_information =
        (prior->covariance + 1e-12 * Matrix6::Identity()).ldlt().solve(Matrix6::Identity());
  Matrix6 information = Matrix6::Identity();
  const int steps = refinement_.iterations;
  for (int step = 0; step < steps; ++step) {
    const double progress = steps > 1 ? static_cast<double>(step) / (steps - 1) : 1;
    const double length =
        refinement_.search_length *
        std::pow(refinement_.final_search_length / refinement_.search_length, progress);
    const double sigma = std::max(refinement_.sigma, length / 4);
    NormalEquations n;
    for (const RefinementView& view : views) {
      const NormalEquations of_view =
          linearize(view, result.pose, length, sigma, prior ? &prior->covariance : nullptr);
      n.h += of_view.h;
      n.g += of_view.g;
      n.matched += of_view.matched;
      n.used += of_view.used;
    }
    result.matched_samples = n.matched;
    result.used_samples = n.used;
    if (n.matched < 6 && !prior) return result;
    information = n.h;
    Twist gradient = n.g;
    if (prior) {
      information += prior_information;
      gradient += prior_information * logSe3(result.pose.inverse() * prior->mean);
    } else {
      // A direction that no edge constrains stays where it is.
      information += 1e-6 * n.h.diagonal().maxCoeff() * Matrix6::Identity();
    }
    Twist delta = information.ldlt().solve(gradient);
    if (!delta.allFinite()) return result;
    constexpr double kLongestMove = 0.25, kLargestTurn = 0.15;  // per step, m and rad
    const double excess =
        std::max(delta.head<3>().norm() / kLongestMove, delta.tail<3>().norm() / kLargestTurn);
    if (excess > 1) delta /= excess;
    result.pose = normalized(result.pose * expSe3(delta));
    result.converged = delta.head<3>().norm() < 1e-4 && delta.tail<3>().norm() < 1.7e-4;
  }
  result.covariance = information.ldlt().solve(Matrix6::Identity());
  return result;
}

}  // namespace edge_mcl
