#include "edge_mcl/localization/filter/mode_proposal.h"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace edge_mcl {

namespace {

/// Keeps a covariance invertible. Standard deviations stay above 0.1 mm and 0.003 degrees.
Matrix6 withFloor(const Matrix6& covariance) {
  Matrix6 result = 0.5 * (covariance + covariance.transpose());
  result.diagonal().head<3>().array() += 1e-8;
  result.diagonal().tail<3>().array() += 3e-9;
  return result;
}

}  // namespace

GaussianDensity::GaussianDensity(const PoseGaussian& gaussian)
    : gaussian_{gaussian.mean, withFloor(gaussian.covariance)},
      inverse_mean_(gaussian.mean.inverse()) {
  factor_ = gaussian_.covariance.llt().matrixL();
  inverse_factor_ = factor_.triangularView<Eigen::Lower>().solve(Matrix6::Identity());
  log_norm_ = -3 * std::log(2 * M_PI) - factor_.diagonal().array().log().sum();
}

double GaussianDensity::logOfOffset(const Twist& offset) const {
  return log_norm_ - 0.5 * (inverse_factor_ * offset).squaredNorm();
}

namespace {

double logSum(double a, double b) {
  const double high = std::max(a, b), low = std::min(a, b);
  return high + std::log1p(std::exp(low - high));
}

}  // namespace

PredictiveDensity::PredictiveDensity(const PoseGaussian& cloud, double tail_share,
                                     const Matrix6& extra)
    : core_(cloud),
      tail_({cloud.mean, cloud.covariance + extra}),
      log_core_share_(std::log1p(-tail_share)),
      log_tail_share_(tail_share > 0 ? std::log(tail_share) : -1e300) {}

double PredictiveDensity::log(const Pose& pose) const {
  const Twist offset = core_.offset(pose);  // core and tail have the same mean
  return logSum(log_core_share_ + core_.logOfOffset(offset),
                log_tail_share_ + tail_.logOfOffset(offset));
}

const PoseGaussian& PredictiveDensity::componentOf(const Pose& pose) const {
  return log_core_share_ + core_.log(pose) >= log_tail_share_ + tail_.log(pose) ? core_.gaussian()
                                                                                : tail_.gaussian();
}

ModeProposal::ModeProposal(const LocalizationMap& map, const std::vector<CameraView>& views,
                           const std::vector<Pose>& predicted, const std::vector<PoseScore>& scores,
                           const PredictiveDensity& predictive, int starts) {
  std::vector<uint32_t> order(predicted.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return scores[a].log_likelihood > scores[b].log_likelihood;
  });
  // Starts are the centre of the predicted cloud and the best particles. A particle is left out
  // when it is closer to a better one than half a standard deviation of the cloud (root mean square
  // over the six axes).
  const Matrix6 information = inverseOf(predictive.core().covariance);
  std::vector<Pose> chosen{predictive.core().mean};
  const size_t looked_at = std::max<size_t>(order.size() / 2, 1);
  for (size_t k = 0; k < looked_at && chosen.size() < static_cast<size_t>(starts); ++k) {
    const Pose& candidate = predicted[order[k]];
    bool fresh = true;
    for (size_t c = 1; c < chosen.size() && fresh; ++c) {
      const Twist d = logSe3(chosen[c].inverse() * candidate);
      fresh = d.dot(information * d) > 0.25 * 6;
    }
    if (fresh) chosen.push_back(candidate);
  }

  std::vector<RefinementResult> refined(chosen.size());
  tbb::parallel_for(size_t{0}, chosen.size(), [&](size_t i) {
    refined[i] = map.refineRoughly(views, chosen[i], predictive.componentOf(chosen[i]));
  });
  std::vector<Pose> poses;
  poses.reserve(refined.size());
  for (const RefinementResult& r : refined) poses.push_back(r.pose);
  const std::vector<PoseScore> at_modes = map.evaluate(views, poses);
  std::vector<double> posterior(poses.size());
  for (size_t i = 0; i < poses.size(); ++i)
    posterior[i] = at_modes[i].log_likelihood + predictive.log(poses[i]);
  std::vector<size_t> by_posterior(poses.size());
  std::iota(by_posterior.begin(), by_posterior.end(), size_t{0});
  std::stable_sort(by_posterior.begin(), by_posterior.end(),
                   [&](size_t a, size_t b) { return posterior[a] > posterior[b]; });

  // A mode this many nats below the best result is left out.
  constexpr double kNegligible = 10;
  // Factor on the estimated covariance. A proposal with heavier tails gives safer weights.
  constexpr double kWider = 3;
  for (size_t i : by_posterior) {
    const RefinementResult& r = refined[i];
    if (r.matched_samples + r.matched_points < 6 || !r.covariance.allFinite()) continue;
    if (posterior[i] < posterior[by_posterior.front()] - kNegligible) break;
    bool fresh = true;
    for (const GaussianDensity& m : modes_) {
      const Twist d = logSe3(m.gaussian().mean.inverse() * r.pose);
      fresh = fresh && squaredMahalanobis(d, m.gaussian().covariance) > 6;
    }
    if (fresh) modes_.emplace_back(PoseGaussian{r.pose, kWider * r.covariance});
  }
}

double ModeProposal::log(const Pose& pose) const {
  double best = -1e300;
  std::vector<double> logs(modes_.size());
  for (size_t i = 0; i < modes_.size(); ++i) best = std::max(best, logs[i] = modes_[i].log(pose));
  double sum = 0;
  for (double l : logs) sum += std::exp(l - best);
  return best + std::log(sum / static_cast<double>(modes_.size()));
}

}  // namespace edge_mcl
