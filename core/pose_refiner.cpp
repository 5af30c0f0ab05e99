#include "edge_mcl/core/pose_refiner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

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

PoseRefiner::ChosenSamples PoseRefiner::choose(const RefinementView& view, const Pose& base_pose,
                                               int most) const {
  const VisibleSet& set = *view.visible;
  const CameraModel& camera = *view.camera;
  const Pose camera_from_map = (base_pose * view.T_base_camera).inverse();
  // Samples near the image are chosen, too: during the refinement the pose moves by about the
  // search length.
  const double margin = 2 * view.pixel_scale * refinement_.search_length;
  std::vector<size_t> near;  // segments whose centre is in the image or close to it
  size_t count = 0;
  for (size_t k = 0; k < set.segments.size(); ++k) {
    const EdgeSegment& edge = set.edgeSegment(set.segments[k]);
    Eigen::Vector2d pixel;
    const Eigen::Vector3d p = camera_from_map * edge.centre.cast<double>();
    if (p.z() < -edge.radius || !camera.project(p, &pixel)) continue;
    const double reach = margin + edge.radius * camera.fx / p.z();
    if (pixel.x() < -reach || pixel.y() < -reach || pixel.x() > camera.width - 1 + reach ||
        pixel.y() > camera.height - 1 + reach)
      continue;
    near.push_back(k);
    if (camera.contains(pixel)) count += edge.sample_count;
  }
  const size_t stride = std::max<size_t>(1, count / static_cast<size_t>(most));
  ChosenSamples chosen;
  chosen.stride = static_cast<double>(stride);
  size_t phase = 0;
  uint32_t last_group = 0;
  for (const size_t k : near) {
    const VisibleSet::Segment& segment = set.segments[k];
    const EdgeSegment& edge = set.edgeSegment(segment);
    const EdgeLine& line = set.line(segment);
    for (uint32_t i = 0; i < edge.sample_count; ++i) {
      if (!(segment.samples >> i & 1u) || phase++ % stride != 0) continue;
      if (!chosen.samples.empty()) chosen.samples.back().ends_group = last_group != line.group;
      last_group = line.group;
      chosen.samples.push_back({set.model->samplePosition(edge, i), line.tangent().cast<double>(),
                                VisibleSet::facingWeight(segment), true, line.group});
    }
  }
  constexpr size_t kPiece = 250;
  chosen.pieces = {0};
  for (size_t i = 0; i < chosen.samples.size(); ++i)
    if (chosen.samples[i].ends_group &&
        (i + 1 == chosen.samples.size() || i + 1 - chosen.pieces.back() >= kPiece))
      chosen.pieces.push_back(i + 1);
  return chosen;
}

PoseRefiner::PoseRefiner(RefinementParameters refinement, LikelihoodParameters likelihood,
                         ImageParameters image)
    : refinement_(refinement), likelihood_(likelihood), image_(image) {}

/// Values that all samples of one image share in a step.
struct PoseRefiner::Step {
  Pose camera_from_map;
  double search_length, sigma, clutter_density, peak;
  float tolerance_cos;
  bool has_prior;
  Matrix6 camera_covariance;  ///< of the prior, for the camera's pose

  Step(const PoseRefiner& refiner, const RefinementView& view, const Pose& base_pose, double length,
       double sigma_px, const Matrix6* prior_covariance)
      : camera_from_map((base_pose * view.T_base_camera).inverse()),
        search_length(length),
        sigma(sigma_px),
        tolerance_cos(
            static_cast<float>(std::cos(refiner.image_.orientation_tolerance_deg * M_PI / 180))),
        has_prior(prior_covariance != nullptr),
        camera_covariance(Matrix6::Zero()) {
    const double e = refiner.likelihood_.missing_edge;
    clutter_density = e / (2 * length);
    peak = (1 - e) / (std::sqrt(2 * M_PI) * sigma);
    // The camera moves with the base: xi_camera = Ad(T_camera_base) xi_base.
    const Matrix6 to_base = adjoint(view.T_base_camera.inverse());
    if (prior_covariance) camera_covariance = to_base * *prior_covariance * to_base.transpose();
  }
};

/// A sample in the image, and the image edge that it is matched with.
struct PoseRefiner::Match {
  Twist row;  ///< derivative of the offset along the normal by the pose of the camera
  Eigen::Vector2d pixel, normal;
  double residual, weight;
};

PoseRefiner::Outcome PoseRefiner::match(const RefinementView& view,
                                        const ChosenSamples::Sample& sample, const Step& step,
                                        Match* match) const {
  const CameraModel& camera = *view.camera;
  const EdgeImage& image = *view.image;
  const Eigen::Vector3d p = step.camera_from_map * sample.point;
  Eigen::Vector2d& pixel = match->pixel;
  Eigen::Matrix<double, 2, 3> projection;
  if (!camera.project(p, &pixel, &projection) || !camera.contains(pixel)) return Outcome::kOutside;
  // The pixel is in the image, so it is not negative, and this rounds it. std::lround is slower.
  const auto nearest = [](double v) {
    return static_cast<int>(v + 0.5);  // NOLINT(bugprone-incorrect-roundings)
  };
  if (!image.ignore.empty() && image.ignore.at<uint8_t>(nearest(pixel.y()), nearest(pixel.x())))
    return Outcome::kOutside;
  const Eigen::Vector2d direction = projection * (step.camera_from_map.linear() * sample.tangent);
  if (direction.squaredNorm() < 1e-12) return Outcome::kOutside;
  match->normal = Eigen::Vector2d(-direction.y(), direction.x()).normalized();
  // row = normal^T * pixelJacobian()
  const Eigen::Vector3d along = projection.transpose() * match->normal;
  match->row << -along, along.cross(p);
  // The prior limits the distance of the edge along this normal (active search).
  double length = step.search_length;
  if (step.has_prior) {
    const double spread = std::sqrt(match->row.dot(step.camera_covariance * match->row));
    length = std::min(length, std::max(view.pixel_scale * refinement_.final_search_length / 2,
                                       3 * spread + 2 * view.pixel_scale));
  }
  const EdgePixel* hit = view.pixels->nearestAlong(
      static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
      static_cast<float>(match->normal.x()), static_cast<float>(match->normal.y()),
      static_cast<float>(length), step.tolerance_cos);
  if (hit == nullptr) return Outcome::kUnmatched;
  const double sigma = step.sigma;
  match->residual = match->normal.dot(Eigen::Vector2d(hit->ridge_x, hit->ridge_y) - pixel);
  const double inlier =
      step.peak * std::exp(-match->residual * match->residual / (2 * sigma * sigma));
  match->weight = sample.facing * inlier / (inlier + step.clutter_density) / (sigma * sigma);
  return Outcome::kMatched;
}

NormalEquations PoseRefiner::linearize(const RefinementView& view, const ChosenSamples& chosen,
                                       const Pose& base_pose, double search_length, double sigma,
                                       const Matrix6* prior_covariance) const {
  const Step step(*this, view, base_pose, search_length, sigma, prior_covariance);
  const auto add = [&](const ChosenSamples::Sample& sample, NormalEquations* line) {
    Match m;
    const Outcome outcome = match(view, sample, step, &m);
    line->used += outcome != Outcome::kOutside;
    if (outcome != Outcome::kMatched) return;
    ++line->matched;
    line->h.noalias() += (m.weight * m.row) * m.row.transpose();
    line->g += m.weight * m.residual * m.row;
  };
  const auto addLines = [&](size_t begin, size_t end) {
    NormalEquations sum, line;
    for (size_t i = begin; i < end; ++i) {
      add(chosen.samples[i], &line);
      if (!chosen.samples[i].ends_group) continue;
      // As in the robust likelihood, a line counts at most as much as `line_saturation` samples.
      const double share =
          chosen.stride / (1 + chosen.stride * line.used / likelihood_.line_saturation);
      line.h *= share;
      line.g *= share;
      sum += line;
      line = {};
    }
    return sum;
  };
  // Pieces hold whole lines. They do not depend on the number of threads, so the sums do not
  // either.
  std::vector<NormalEquations> sums(chosen.pieces.size() - 1);
  tbb::parallel_for(size_t{0}, sums.size(),
                    [&](size_t p) { sums[p] = addLines(chosen.pieces[p], chosen.pieces[p + 1]); });
  NormalEquations total;
  for (const NormalEquations& sum : sums) total += sum;
  const Matrix6 to_base = adjoint(view.T_base_camera.inverse());
  total.h = to_base.transpose() * total.h * to_base;
  total.g = to_base.transpose() * total.g;
  return total;
}

NormalEquations PoseRefiner::linearizeDepth(const RefinementView& view, const Pose& base_pose,
                                            double progress) const {
  // At the first step points are pulled from as far as the distance field reaches (3 sigma). At the
  // last step only their noise counts.
  constexpr double kFinalSigma = 0.005;
  const double first_sigma = depth_->field().truncation() / 3;
  const double sigma = first_sigma * std::pow(kFinalSigma / first_sigma, progress);
  NormalEquations n = depth_->linearize(*view.depth, base_pose * view.T_base_camera, sigma);
  const Matrix6 to_base = adjoint(view.T_base_camera.inverse());
  n.h = to_base.transpose() * n.h * to_base;
  n.g = to_base.transpose() * n.g;
  return n;
}

PoseObservation PoseRefiner::observe(const std::vector<RefinementView>& views,
                                     const Pose& base_pose) const {
  PoseObservation seen;
  for (const RefinementView& view : views) {
    if (view.depth && depth_) seen.depth_information += linearizeDepth(view, base_pose, 1).h;
    if (!view.camera) continue;
    const double length = view.pixel_scale * refinement_.final_search_length;
    const Step step(*this, view, base_pose, length,
                    std::max(view.pixel_scale * refinement_.sigma, length / 4), nullptr);
    const Eigen::Vector2d centre(view.camera->cx, view.camera->cy);
    const Matrix6 from_camera = adjoint(view.T_base_camera.inverse()).transpose();
    const ChosenSamples chosen = choose(view, base_pose, refinement_.max_samples);
    CameraObservation camera;
    std::vector<Match> of_line;
    int used = 0;
    for (const ChosenSamples::Sample& sample : chosen.samples) {
      Match m;
      const Outcome outcome = match(view, sample, step, &m);
      used += outcome != Outcome::kOutside;
      if (outcome == Outcome::kMatched) of_line.push_back(m);
      if (!sample.ends_group) continue;
      const double share = chosen.stride / (1 + chosen.stride * used / likelihood_.line_saturation);
      const size_t middle = of_line.size() / 2;
      for (const bool second : {false, true}) {
        PoseObservation::Piece piece;
        for (size_t i = second ? middle : 0; i < (second ? of_line.size() : middle); ++i)
          add(of_line[i], share, centre, &camera, &piece);
        if (!(piece.weight > 0)) continue;
        piece.key = 2 * sample.group + (second ? 1 : 0);
        piece.offset /= piece.weight * view.pixel_scale;
        piece.pull = view.pixel_scale * (from_camera * piece.pull);
        seen.pieces.push_back(piece);
      }
      of_line.clear();
      used = 0;
    }
    camera.pose_information = from_camera * camera.pose_information * from_camera.transpose();
    camera.pose_gradient = from_camera * camera.pose_gradient;
    camera.pull = from_camera * camera.pull;
    seen.information += camera.pose_information;
    seen.cameras.push_back(camera);
  }
  return seen;
}

void PoseRefiner::add(const Match& m, double share, const Eigen::Vector2d& centre,
                      CameraObservation* camera, PoseObservation::Piece* piece) {
  const double weight = share * m.weight;
  const Eigen::Vector3d by_calibration((m.pixel - centre).dot(m.normal), m.normal.x(),
                                       m.normal.y());
  camera->pose_information.noalias() += (weight * m.row) * m.row.transpose();
  camera->pose_gradient += weight * m.residual * m.row;
  camera->pull.noalias() += (weight * m.row) * by_calibration.transpose();
  camera->information.noalias() += (weight * by_calibration) * by_calibration.transpose();
  camera->gradient += weight * m.residual * by_calibration;
  piece->pull += weight * m.row;
  piece->offset += weight * m.residual;
  piece->weight += weight;
  piece->samples += share;
}

RefinementResult PoseRefiner::refine(const std::vector<RefinementView>& views, const Pose& start,
                                     const std::optional<PoseGaussian>& prior,
                                     const RefinementEffort& effort) const {
  RefinementResult result;
  result.pose = start;
  Matrix6 prior_information = Matrix6::Zero();
  if (prior) prior_information = inverseOf(prior->covariance + 1e-12 * Matrix6::Identity());
  Matrix6 information = Matrix6::Identity();
  const int steps = effort.iterations;
  std::vector<ChosenSamples> chosen;
  chosen.reserve(views.size());
  for (const RefinementView& view : views)
    chosen.push_back(view.camera ? choose(view, start, effort.samples) : ChosenSamples());
  for (int step = 0; step < steps; ++step) {
    const double progress = steps > 1 ? static_cast<double>(step) / (steps - 1) : 1;
    const double length =
        refinement_.search_length *
        std::pow(refinement_.final_search_length / refinement_.search_length, progress);
    const double sigma = std::max(refinement_.sigma, length / 4);
    NormalEquations n;
    for (size_t k = 0; k < views.size(); ++k) {
      if (views[k].camera)
        n += linearize(views[k], chosen[k], result.pose, views[k].pixel_scale * length,
                       views[k].pixel_scale * sigma, prior ? &prior->covariance : nullptr);
      if (views[k].depth && depth_) n += linearizeDepth(views[k], result.pose, progress);
    }
    result.matched_samples = n.matched;
    result.used_samples = n.used;
    result.matched_points = n.matched_points;
    if (n.matched + n.matched_points < 6 && !prior) return result;
    information = n.h;
    Twist gradient = n.g;
    if (prior) {
      information += prior_information;
      gradient += prior_information * logSe3(result.pose.inverse() * prior->mean);
    } else {
      // A direction that no edge constrains must not move.
      information += 1e-6 * n.h.diagonal().maxCoeff() * Matrix6::Identity();
    }
    Twist delta = solve(information, gradient);
    if (!delta.allFinite()) return result;
    constexpr double kLongestMove = 0.25, kLargestTurn = 0.15;  // per step, m and rad
    const double excess =
        std::max(delta.head<3>().norm() / kLongestMove, delta.tail<3>().norm() / kLargestTurn);
    if (excess > 1) delta /= excess;
    result.pose = normalized(result.pose * expSe3(delta));
    result.converged = delta.head<3>().norm() < 1e-4 && delta.tail<3>().norm() < 1.7e-4;
  }
  result.covariance = inverseOf(information);
  return result;
}

}  // namespace edge_mcl
