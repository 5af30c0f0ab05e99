#include "edge_mcl/localization/filter/pose_filter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/contrast.h"
#include "edge_mcl/localization/filter/mode_proposal.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/filter/resampling.h"

namespace edge_mcl {

namespace {

using Clock = std::chrono::steady_clock;
double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double square(double x) { return x * x; }

}  // namespace

PoseFilter::PoseFilter(FilterParameters filter, RefinementParameters refinement)
    : params_(filter), refinement_(refinement), random_(filter.seed) {}

void PoseFilter::initialize(const PoseGaussian& gaussian) {
  if (!isValid(gaussian.mean) || !gaussian.covariance.allFinite())
    throw InputError(
        "filter: the initial pose or its covariance is not finite, or the pose is farther away "
        "than any place on earth");
  const GaussianDensity density(gaussian);
  poses_.resize(params_.particles);
  for (Pose& pose : poses_) pose = density.draw(&random_);
  log_weights_.assign(poses_.size(), 0);
  estimate_ = gaussian;
  covariance_.reset(gaussian.covariance);
  last_estimate_.reset();
  since_last_estimate_ = 0;
  velocity_.setZero();
  noise_variance_.setZero();
  depth_biases_.clear();  // they may have been learnt at a wrong pose
  edges_fit_ = depth_fit_ = RecoveryAverages();
}

void PoseFilter::initialize(const Pose& mean, double std_position, double std_angle) {
  PoseGaussian gaussian;
  gaussian.mean = mean;
  gaussian.covariance.diagonal().head<3>().setConstant(std_position * std_position);
  gaussian.covariance.diagonal().tail<3>().setConstant(std_angle * std_angle);
  initialize(gaussian);
}

void PoseFilter::setParticles(std::vector<Pose> poses, std::vector<double> log_weights) {
  if (poses.empty() || poses.size() != log_weights.size())
    throw Error("filter: there are no particles, or the number of weights differs from theirs");
  for (size_t i = 0; i < poses.size(); ++i)
    if (!isValid(poses[i]) || std::isnan(log_weights[i]))
      throw InputError(
          "filter: particle " + std::to_string(i) +
          " has a pose that is not finite or not on earth, or a weight that is not a number");
  poses_ = std::move(poses);
  log_weights_ = std::move(log_weights);
  estimate_ = meanAndCovariance(poses_, normalizedWeights());
  covariance_.reset(estimate_.covariance);
  last_estimate_.reset();
  velocity_.setZero();
  depth_biases_.clear();
  edges_fit_ = depth_fit_ = RecoveryAverages();
}

std::vector<double> PoseFilter::normalizedWeights() const { return normalize(log_weights_); }

void PoseFilter::resampleIfNeeded() {
  // weigh() replaces particles by their number and keeps the weight of that number. This is right
  // only when all weights are equal.
  const bool always = refinement_.enabled && params_.refined_share > 0;
  const std::vector<double> weights = normalizedWeights();
  const double ess = effectiveSampleSize(weights);
  const auto n = static_cast<double>(poses_.size());
  if (ess > n - 1e-6 && poses_.size() == static_cast<size_t>(params_.particles)) return;
  if (!always && ess >= params_.resample_threshold * n) return;
  std::vector<Pose> drawn;
  drawn.reserve(params_.particles);
  for (uint32_t i : systematicResample(weights, params_.particles, random_.uniform()))
    drawn.push_back(poses_[i]);
  poses_ = std::move(drawn);
  log_weights_.assign(poses_.size(), 0);
}

namespace {

/// Whether the index belongs to an evenly spaced share of all indices. After resampling, neighbours
/// are copies of one particle. Even spacing takes the same share of the copies of every particle.
bool isInEvenShare(size_t i, double share) {
  return std::floor(share * static_cast<double>(i + 1)) >
         std::floor(share * static_cast<double>(i));
}

std::vector<size_t> evenShare(size_t n, double share) {
  std::vector<size_t> chosen;
  for (size_t i = 0; i < n; ++i)
    if (isInEvenShare(i, share)) chosen.push_back(i);
  return chosen;
}

}  // namespace

double PoseFilter::shareToInject() const {
  // At least half of the particles stay where motion predicts them, however badly the images fit.
  constexpr double kMost = 0.5;
  return std::min(std::max(edges_fit_.shareToInject(), depth_fit_.shareToInject()), kMost);
}

void PoseFilter::drawTails(const PredictiveDensity& predictive, double share) {
  // weigh() later replaces the particles in `redrawn`. Both lists get the same share of tails.
  // Otherwise the particles that stay would hold more tails than the predictive density says.
  std::vector<size_t> kept, redrawn;
  for (size_t i = 0; i < poses_.size(); ++i)
    (refinement_.enabled && isInEvenShare(i, params_.refined_share) ? redrawn : kept).push_back(i);
  for (const std::vector<size_t>* part : {&kept, &redrawn})
    for (const size_t k : evenShare(part->size(), share))
      poses_[(*part)[k]] = predictive.drawTail(&random_);
}

void PoseFilter::weigh(const LocalizationMap& map, const std::vector<CameraView>& views,
                       const std::vector<CameraView>& thinned, const PredictiveDensity& predictive,
                       double remaining_exponent, UpdateReport* report) {
  const size_t n = poses_.size();
  auto start = Clock::now();
  std::vector<PoseScore> scores = map.evaluate(thinned, poses_);
  report->likelihood_ms += millisecondsSince(start);

  std::vector<double> log_ratio(n, 0);  // log(p / q)
  const double share = params_.refined_share;
  if (refinement_.enabled && share > 0) {
    start = Clock::now();
    const ModeProposal modes(map, views, poses_, scores, predictive, refinement_.starts);
    report->refinement_ms += millisecondsSince(start);
    report->refined_modes = static_cast<int>(modes.size());
    if (!modes.empty()) {
      const std::vector<size_t> redrawn = evenShare(n, share);
      std::vector<Pose> fresh;
      for (size_t k = 0; k < redrawn.size(); ++k)
        fresh.push_back(modes.mode(k % modes.size()).draw(&random_));
      start = Clock::now();
      const std::vector<PoseScore> fresh_scores = map.evaluate(thinned, fresh);
      report->likelihood_ms += millisecondsSince(start);
      for (size_t k = 0; k < redrawn.size(); ++k) {
        poses_[redrawn[k]] = fresh[k];
        scores[redrawn[k]] = fresh_scores[k];
      }
      tbb::parallel_for(size_t{0}, n, [&](size_t i) {
        // q = (1 - share) p + share m, where m is the density of the modes. Hence
        // p / q = 1 / (1 - share + share m / p).
        const double m_over_p = modes.log(poses_[i]) - predictive.log(poses_[i]);
        log_ratio[i] = m_over_p > 300 ? -m_over_p - std::log(share)
                                      : -std::log(1 - share + share * std::exp(m_over_p));
      });
    }
  }
  std::vector<double> fixed(n), likelihood(n);
  for (size_t i = 0; i < n; ++i) {
    report->has_information |= scores[i].sample_weight > 0 || scores[i].depth_points > 0;
    fixed[i] = log_weights_[i] + log_ratio[i];
    likelihood[i] = remaining_exponent * scores[i].log_likelihood;
  }
  const double exponent = temperingExponent(fixed, likelihood, params_.ess_floor);
  report->tempering += exponent * remaining_exponent;
  full_log_weights_.resize(n);
  for (size_t i = 0; i < n; ++i) {
    log_weights_[i] = fixed[i] + exponent * likelihood[i];
    full_log_weights_[i] = fixed[i] + likelihood[i];
  }
}

Matrix6 PoseFilter::otherModes(const Pose& centre, const Matrix6& width) const {
  constexpr double kFar = 16;  // squared Mahalanobis distance
  const Matrix6 information = inverseOf(width);
  const Pose inverse = centre.inverse();
  const std::vector<double> weights = normalize(full_log_weights_);
  Matrix6 moment = Matrix6::Zero();
  for (size_t i = 0; i < poses_.size(); ++i) {
    if (weights[i] < 1e-9) continue;
    const Twist offset = logSe3(inverse * poses_[i]);
    if (offset.dot(information * offset) > kFar) moment += weights[i] * offset * offset.transpose();
  }
  return moment;
}

bool PoseFilter::spreadBeyondNormals(const LocalizationMap& map,
                                     const std::vector<CameraView>& views,
                                     const PoseGaussian& cloud) const {
  const double angle = std::sqrt(cloud.covariance.diagonal().tail<3>().mean());
  const double position = std::sqrt(cloud.covariance.diagonal().head<3>().mean());
  for (const CameraView& view : views) {
    if (view.depth && map.usesDepth() &&
        std::hypot(position, angle * view.depth->mean_depth) > map.params().depth.truncation / 3)
      return true;
    if (!view.image) continue;
    const CameraModel& camera = view.image->frame.camera;
    const Pose camera_pose = cloud.mean * view.T_base_camera;
    const auto set = map.visibility().cached(map.visibility().cellOf(camera_pose.translation()));
    std::vector<double> depths;
    for (const VisibleSet::Segment& s : set->segments) {
      Eigen::Vector2d pixel;
      const Eigen::Vector3d p = camera_pose.inverse() * set->edgeSegment(s).centre.cast<double>();
      if (camera.project(p, &pixel) && camera.contains(pixel)) depths.push_back(p.z());
    }
    if (depths.empty()) continue;
    const auto middle = depths.begin() + static_cast<long>(depths.size() / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    const double pixels = camera.fx * std::hypot(angle, position / *middle);
    if (pixels > view.image->pixel_scale * refinement_.search_length / 2) return true;
  }
  return false;
}

void PoseFilter::spreadCopies(const PoseGaussian& cloud) {
  // A kernel with shrinkage keeps mean and covariance (J. Liu, M. West, "Combined parameter and
  // state estimation in simulation-based filtering", 2001).
  constexpr double kBandwidth = 0.3;
  const double shrink = std::sqrt(1 - kBandwidth * kBandwidth);
  const GaussianDensity kernel({Pose::Identity(), kBandwidth * kBandwidth * cloud.covariance});
  const Pose inverse = cloud.mean.inverse();
  for (Pose& pose : poses_)
    pose = normalized(cloud.mean * expSe3(shrink * logSe3(inverse * pose)) * kernel.draw(&random_));
}

PoseScore PoseFilter::sharpenEstimate(const LocalizationMap& map,
                                      const std::vector<CameraView>& views,
                                      const PoseGaussian& cloud,
                                      const PredictiveDensity& predictive, UpdateReport* report) {
  const auto start = Clock::now();
  RefinementResult sharp;
  sharp.pose = cloud.mean;
  if (refinement_.enabled)
    sharp = map.refine(views, cloud.mean, predictive.componentOf(cloud.mean));
  const std::vector<PoseScore> compared = map.evaluate(views, {cloud.mean, sharp.pose});
  const bool is_better =
      refinement_.enabled && compared[1].log_likelihood + predictive.log(sharp.pose) >=
                                 compared[0].log_likelihood + predictive.log(cloud.mean);
  if (!is_better) sharp = map.match(views, cloud.mean);
  report->refinement_ms += millisecondsSince(start);
  report->matched_samples = sharp.matched_samples;
  report->used_samples = sharp.used_samples;
  if (!refinement_.enabled) return compared[0];  // the estimate is that of the particles
  estimate_.mean = is_better ? sharp.pose : cloud.mean;
  // In clean rooms the variance of the particles is up to this many times that of the refinement.
  constexpr double kWide = 6;
  const PoseObservation seen = map.observe(views, estimate_.mean);
  const Matrix6& prior = predictive.core().covariance;
  const Matrix6 narrow = inverseOf(inverseOf(prior + 1e-12 * Matrix6::Identity()) +
                                   seen.information + seen.depth_information);
  covariance_.correct(seen, prior, otherModes(estimate_.mean, kWide * narrow));
  if (report->passes > 1) {
    // The particles are spread wider than the refinement reaches, so it may have found another mode
    // than that of the true pose. The spread of the particles tells.
    const Twist shift = logSe3(estimate_.mean.inverse() * cloud.mean);
    covariance_.widen(cloud.covariance + shift * shift.transpose());
  }
  estimate_.covariance = covariance_.covariance();
  const Matrix6 own = estimate_.covariance + kWide * covariance_.refined();
  estimate_.covariance += otherModes(estimate_.mean, own);
  report->line_sigma = covariance_.lineSigma();
  return compared[is_better ? 1 : 0];
}

std::vector<CameraView> PoseFilter::withoutBias(const LocalizationMap& map,
                                                std::vector<CameraView> views) {
  const double sigma = map.params().depth.bias_sigma;
  for (CameraView& view : views) {
    if (!view.depth || !map.usesDepth()) continue;
    const DepthBias& bias =
        depth_biases_.emplace(view.depth_sensor, DepthBias{0, sigma * sigma}).first->second;
    view.depth = std::make_shared<DepthPoints>(edge_mcl::withoutBias(*view.depth, bias));
  }
  return views;
}

void PoseFilter::learnBias(const LocalizationMap& map, const std::vector<CameraView>& views,
                           UpdateReport* report) {
  constexpr double kTrusted = 0.5;  // least share of the points on the model for learning
  // Images of one scene have correlated errors. So the standard deviation of the bias stays above
  // this share of its prior standard deviation.
  constexpr double kLeastShare = 0.15;
  constexpr double kFarthest = 3;  // largest bias, in prior standard deviations
  const double sigma = map.params().depth.bias_sigma;
  for (const CameraView& view : views) {
    if (!view.depth || !map.usesDepth()) continue;
    DepthBias& bias = depth_biases_[view.depth_sensor];
    report->depth_bias = bias.mean;
    if (report->depth_agreement < kTrusted) continue;
    const Matrix6 to_camera = adjoint(view.T_base_camera.inverse());
    const DepthBias rest =
        map.depth()->remainingBias(*view.depth, estimate_.mean * view.T_base_camera,
                                   to_camera * estimate_.covariance * to_camera.transpose());
    const double least = kLeastShare * sigma;
    bias.mean = std::clamp(bias.mean + rest.mean, -kFarthest * sigma, kFarthest * sigma);
    bias.variance = std::min(bias.variance, std::max(rest.variance, least * least));
    report->depth_bias = bias.mean;
  }
}

UpdateReport PoseFilter::update(const LocalizationMap& map,
                                const std::vector<CameraView>& raw_views) {
  const auto begin = Clock::now();
  UpdateReport report;
  const std::vector<CameraView> views = withoutBias(map, raw_views);
  const PoseGaussian expected{estimate_.mean, covariance_.covariance()};
  report.innovation_of_images = covariance_.refined();
  // Particles are weighed by a share of the samples, to save time. Single poses are scored by all.
  std::vector<CameraView> thinned = views;
  for (CameraView& view : thinned)
    view.thinning = map.thinningFor(view, estimate_.mean,
                                    static_cast<size_t>(map.params().likelihood.max_samples));
  std::optional<PredictiveDensity> predictive;
  report.injected_share = shareToInject();
  Twist injected = Twist::Zero();  // variance
  if (report.injected_share > 0)
    injected << Eigen::Vector3d::Constant(square(params_.recovery_std_position)),
        Eigen::Vector3d::Constant(square(params_.recovery_std_angle_deg * M_PI / 180));
  for (int pass = 0; pass < params_.max_passes; ++pass) {
    // Tails cover unexpected motion. In them the standard deviation of the motion noise is
    // `tail_scale` times larger.
    const bool usual_tails = refinement_.enabled && !noise_variance_.isZero();
    const double tails = std::max(usual_tails ? params_.tail_share : 0, report.injected_share);
    const Matrix6 extra =
        Twist((square(params_.tail_scale) - 1) * noise_variance_ + injected).asDiagonal();
    const PredictiveDensity before(meanAndCovariance(poses_, normalizedWeights()), tails, extra);
    noise_variance_.setZero();
    injected.setZero();
    if (pass == 0) predictive.emplace(before);
    if (tails > 0) drawTails(before, tails);
    weigh(map, views, thinned, before, 1 - report.tempering, &report);
    ++report.passes;
    const std::vector<double> weights = normalizedWeights();
    report.effective_sample_size = effectiveSampleSize(weights);
    estimate_ = meanAndCovariance(poses_, weights);
    const bool again = pass + 1 < params_.max_passes && report.tempering < 1 &&
                       report.has_information && spreadBeyondNormals(map, views, before.core());
    if (!again) break;
    resampleIfNeeded();
    spreadCopies(estimate_);
  }
  const PoseScore at_estimate =
      report.has_information
          ? sharpenEstimate(map, views, PoseGaussian(estimate_), *predictive, &report)
          : map.evaluate(views, {estimate_.mean}).front();
  report.log_likelihood = at_estimate.log_likelihood;
  report.visible_samples = at_estimate.sample_weight;
  report.visible_lines = at_estimate.line_count;
  report.evidence_per_line = at_estimate.scorePerLine();
  report.depth_points = static_cast<int>(at_estimate.depth_points);
  if (at_estimate.depth_points > 0)
    report.depth_agreement =
        static_cast<double>(at_estimate.depth_points_on_model / at_estimate.depth_points);
  if (report.has_information) {
    report.contrast = contrastOf(map, thinned, estimate_.mean);
    const Eigen::Vector3d c = covariance_.calibrationError();
    report.focal_error = c[0];
    report.centre_error = c.tail<2>();
  }
  if (report.visible_lines > 0) edges_fit_.add(report.evidence_per_line, params_);
  if (report.depth_points > 0) depth_fit_.add(report.depth_agreement, params_);
  if (report.has_information) {
    report.innovation = logSe3(expected.mean.inverse() * estimate_.mean);
    report.innovation_of_images += covariance_.refined();
    learnBias(map, views, &report);
    trackVelocity({predictive->core().mean, expected.covariance});
  }
  report.total_ms = millisecondsSince(begin);
  return report;
}

}  // namespace edge_mcl
