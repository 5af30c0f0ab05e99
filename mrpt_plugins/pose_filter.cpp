#include "edge_mcl/mrpt_plugins/pose_filter.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "edge_mcl/core/error.h"
#include "edge_mcl/mrpt_plugins/mode_proposal.h"
#include "edge_mcl/mrpt_plugins/resampling.h"

namespace edge_mcl {

namespace {

using Clock = std::chrono::steady_clock;
double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

PoseFilter::PoseFilter(FilterParameters filter, RefinementParameters refinement)
    : params_(filter), refinement_(refinement), random_(filter.seed) {}

void PoseFilter::initialize(const PoseGaussian& gaussian) {
  if (!isValid(gaussian.mean) || !gaussian.covariance.allFinite())
    throw InputError("filter: the initial pose is not a finite pose with a finite covariance");
  const GaussianDensity density(gaussian);
  poses_.resize(params_.particles);
  for (Pose& pose : poses_) pose = density.draw(&random_);
  log_weights_.assign(poses_.size(), 0);
  estimate_ = gaussian;
  last_estimate_.reset();
  since_last_estimate_ = 0;
  velocity_.setZero();
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
    throw Error("filter: no particles, or a different number of weights");
  for (size_t i = 0; i < poses.size(); ++i)
    if (!isValid(poses[i]) || std::isnan(log_weights[i]))
      throw InputError("filter: particle " + std::to_string(i) + " is not a finite pose");
  poses_ = std::move(poses);
  log_weights_ = std::move(log_weights);
}

std::vector<double> PoseFilter::normalizedWeights() const { return normalize(log_weights_); }

void PoseFilter::resampleIfNeeded() {
  // Particles drawn from the mixture proposal need equal weights before them.
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

void PoseFilter::addNoise(double std_position, double std_angle) {
  Twist scale;
  scale << std_position, std_position, std_position, std_angle, std_angle, std_angle;
  for (Pose& pose : poses_)
    pose = normalized(pose * expSe3(scale.cwiseProduct(random_.normalTwist())));
}

void PoseFilter::predictWithOdometry(const Pose& increment, double dt) {
  if (!isValid(increment) || !std::isfinite(dt) || dt < 0)
    throw InputError("filter: the odometry increment is not a finite pose over a positive time");
  resampleIfNeeded();
  for (Pose& pose : poses_) pose = pose * increment;
  constexpr double kReferenceTime = 0.1, kDegree = M_PI / 180;
  const double root = std::sqrt(dt / kReferenceTime);
  addNoise(params_.odometry_noise_position * root +
               params_.odometry_noise_per_metre * increment.translation().norm(),
           params_.odometry_noise_angle_deg * kDegree * root +
               params_.odometry_noise_per_radian * logSo3(increment.linear()).norm());
  estimate_.mean = normalized(estimate_.mean * increment);
  since_last_estimate_ += dt;
}

void PoseFilter::predictWithoutOdometry(double dt) {
  if (!std::isfinite(dt) || dt < 0) throw InputError("filter: the time step is not positive");
  resampleIfNeeded();
  const Pose increment = expSe3(velocity_ * dt);
  for (Pose& pose : poses_) pose = pose * increment;
  const double root = std::sqrt(dt);
  addNoise(params_.walk_position_rate * root, params_.walk_angle_rate_deg * M_PI / 180 * root);
  estimate_.mean = normalized(estimate_.mean * increment);
  since_last_estimate_ += dt;
}

void PoseFilter::trackVelocity() {
  if (last_estimate_ && since_last_estimate_ > 1e-6) {
    const Twist newest =
        logSe3(last_estimate_->inverse() * estimate_.mean) / since_last_estimate_;
    velocity_ += params_.velocity_smoothing * (newest - velocity_);
  }
  last_estimate_ = estimate_.mean;
  since_last_estimate_ = 0;
}

UpdateReport PoseFilter::update(const LocalizationMap& map, const std::vector<CameraView>& views) {
  const auto begin = Clock::now();
  UpdateReport report;
  const size_t n = poses_.size();
  const std::vector<double> prior_weights = normalizedWeights();
  const GaussianDensity predictive(meanAndCovariance(poses_, prior_weights));

  auto start = Clock::now();
  std::vector<PoseScore> scores = map.evaluate(views, poses_);
  report.likelihood_ms += millisecondsSince(start);

  std::vector<double> log_ratio(n, 0);  // log p/q
  if (refinement_.enabled) {
    start = Clock::now();
    const ModeProposal modes(map, views, poses_, scores, predictive, refinement_.starts);
    report.refinement_ms += millisecondsSince(start);
    report.refined_modes = static_cast<int>(modes.size());
    const double share = params_.refined_share;
    if (!modes.empty() && share > 0) {
      // Every so many-th particle is drawn anew; neighbours stem from one ancestor, so this takes
      // the same share from each.
      std::vector<size_t> redrawn;
      for (size_t i = 0; i < n; ++i)
        if (std::floor(share * static_cast<double>(i + 1)) >
            std::floor(share * static_cast<double>(i)))
          redrawn.push_back(i);
      std::vector<Pose> fresh;
      for (size_t k = 0; k < redrawn.size(); ++k)
        fresh.push_back(modes.mode(k % modes.size()).draw(&random_));
      start = Clock::now();
      const std::vector<PoseScore> fresh_scores = map.evaluate(views, fresh);
      report.likelihood_ms += millisecondsSince(start);
      for (size_t k = 0; k < redrawn.size(); ++k) {
        poses_[redrawn[k]] = fresh[k];
        scores[redrawn[k]] = fresh_scores[k];
      }
      for (size_t i = 0; i < n; ++i) {
        // q = (1 - share) p + share m, hence p/q = 1 / (1 - share + share m/p).
        const double m_over_p = modes.log(poses_[i]) - predictive.log(poses_[i]);
        log_ratio[i] = m_over_p > 300 ? -m_over_p - std::log(share)
                                      : -std::log(1 - share + share * std::exp(m_over_p));
      }
    }
  }

  for (const PoseScore& s : scores) report.has_information |= s.sample_weight > 0;
  std::vector<double> fixed(n), likelihood(n);
  for (size_t i = 0; i < n; ++i) {
    fixed[i] = log_weights_[i] + log_ratio[i];
    likelihood[i] = scores[i].log_likelihood;
  }
  report.tempering = temperingExponent(fixed, likelihood, params_.ess_floor);
  for (size_t i = 0; i < n; ++i) log_weights_[i] = fixed[i] + report.tempering * likelihood[i];
  const std::vector<double> weights = normalizedWeights();
  report.effective_sample_size = effectiveSampleSize(weights);

  const PoseGaussian cloud = meanAndCovariance(poses_, weights);
  estimate_ = cloud;
  if (refinement_.enabled && report.has_information) {
    start = Clock::now();
    const RefinementResult sharp = map.refine(views, cloud.mean, predictive.gaussian());
    report.refinement_ms += millisecondsSince(start);
    const std::vector<PoseScore> compared = map.evaluate(views, {cloud.mean, sharp.pose});
    const bool better = compared[1].log_likelihood + predictive.log(sharp.pose) >=
                        compared[0].log_likelihood + predictive.log(cloud.mean);
    if (better) {
      // The cloud's spread, seen from the refined pose: tempering makes it a cautious figure.
      const Twist shift = logSe3(sharp.pose.inverse() * cloud.mean);
      estimate_.mean = sharp.pose;
      estimate_.covariance = cloud.covariance + shift * shift.transpose();
    }
    report.matched_samples = sharp.matched_samples;
    report.used_samples = sharp.used_samples;
  }
  const PoseScore at_estimate = map.evaluate(views, {estimate_.mean}).front();
  report.log_likelihood = at_estimate.log_likelihood;
  report.visible_samples = at_estimate.sample_weight;
  report.visible_lines = at_estimate.line_count;
  if (report.has_information) trackVelocity();
  report.total_ms = millisecondsSince(begin);
  return report;
}

}  // namespace edge_mcl
