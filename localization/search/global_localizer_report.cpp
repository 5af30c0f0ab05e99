// The part of GlobalLocalizer that judges its hypotheses and reports them.
#include <algorithm>
#include <cmath>

#include "edge_mcl/localization/search/global_localizer.h"
#include "edge_mcl/localization/search/ranked_poses.h"

namespace edge_mcl {

double GlobalLocalizer::addClusters(SearchReport* report) const {
  constexpr size_t kMost = 10;  // places in a report
  std::vector<double> totals;
  double next = 0;  // score of a pose without any evidence
  for (const Hypothesis& h : hypotheses_) {
    const bool same =
        std::any_of(report->clusters.begin(), report->clusters.end(),
                    [&](const PoseCluster& c) { return isNear(c.pose, h.pose, kSamePlace); });
    if (same || report->clusters.size() >= kMost) continue;
    if (report->clusters.size() == 1) next = std::max(next, h.total);
    report->clusters.push_back({h.pose, 0, h.total});
    totals.push_back(h.total);
  }
  const std::vector<double> probabilities = placeProbabilities(totals, keyframes_.size());
  for (size_t i = 0; i < totals.size(); ++i) report->clusters[i].probability = probabilities[i];
  return next;
}

GlobalLocalizer::Support GlobalLocalizer::addMeans(const Hypothesis& best, SearchReport* report) {
  Support support;
  for (const FoundPose& f : best.history) {
    if (f.match_ratio >= 0) {
      report->evidence += f.evidence;
      report->match_ratio += f.match_ratio;
      ++support.images;
    }
    if (f.depth_agreement >= 0) {
      report->depth_agreement += f.depth_agreement;
      ++support.depths;
    }
  }
  report->evidence /= std::max(1, support.images);
  report->match_ratio /= std::max(1, support.images);
  report->depth_agreement /= std::max(1, support.depths);
  return support;
}

double GlobalLocalizer::neededMargin(const SearchReport& report, const Support& support) const {
  const SearchParameters& p = map_.params().search;
  if (support.images == 0) return p.min_margin;
  // When the images show a smaller part of the model, this part must prove more.
  const double shortfall = std::max(1.0, p.min_match_ratio / std::max(report.match_ratio, 0.01));
  const double margin = p.min_margin * (shortfall * shortfall);
  const LikelihoodParameters& likelihood = map_.params().likelihood;
  if (likelihood.model == LikelihoodModel::kRobust) return margin;
  // Paper model: an image scores at most k (eq. 3), and the best wrong place scores most of that.
  constexpr double kShareOfAll = 1.0 / 6;
  return std::min(margin, kShareOfAll * likelihood.k * p.window);
}

bool GlobalLocalizer::isExplained(const SearchReport& report, const Support& support) const {
  constexpr double kLeastRatio = 0.3;  // below it the images do not show most of the model
  const SearchParameters& p = map_.params().search;
  if (support.images > 0 && report.match_ratio < kLeastRatio) return false;
  const bool robust = map_.params().likelihood.model == LikelihoodModel::kRobust;
  if (support.images > 0 && robust && report.evidence < p.min_evidence) return false;
  return support.depths == 0 ||
         report.depth_agreement >= map_.params().tracking.min_depth_agreement;
}

bool GlobalLocalizer::hasRival(double needed_margin) const {
  // Shelves and stairs look alike one step farther. The pose is not known while a neighbour
  // explains the images nearly as well. Nearly means: its score is lower by less than this share of
  // the margin to other places.
  constexpr double kShare = 0.3;
  const Hypothesis& best = hypotheses_.front();
  return std::any_of(hypotheses_.begin() + 1, hypotheses_.end(), [&](const Hypothesis& h) {
    return h.total > best.total - kShare * needed_margin && !isNear(h.pose, best.pose, kNeighbour);
  });
}

void GlobalLocalizer::addNextView(SearchReport* report) const {
  // A place that is less likely by this factor is no reason to fly somewhere.
  constexpr double kRival = 0.2;
  const std::vector<PoseCluster>& places = report->clusters;
  if (report->convincing || places.size() < 2 ||
      places[1].probability < kRival * places[0].probability)
    return;
  report->next_view = nextView(map_, keyframes_.back().seen.views, places[0].pose, places[1].pose);
}

std::optional<Twist> GlobalLocalizer::velocityOf(const Hypothesis& h) const {
  // A hypothesis that was found beside the true pose moves onto it, and this is no motion of the
  // robot. So its newest pose is followed backwards. Where this fits an older image better than the
  // pose that the hypothesis had there, it is believed. Over a longer time the velocity changes.
  constexpr double kLongest = 0.3;  // s
  FoundPose before = h.newest;
  double elapsed = 0;
  for (size_t k = keyframes_.size() - 1; k > 0; --k) {
    const BaseMotion& since = keyframes_[k].since;
    if (since.blind <= 0 || (elapsed > 0 && elapsed + since.elapsed > kLongest)) break;
    const FoundPose back =
        followed(keyframes_[k - 1].seen, predicted(before, since.step.inverse(), since.variance));
    const FoundPose& forth = h.history[k - 1];
    const bool fits = forth.evidence >= map_.params().search.min_evidence;
    before = fits && forth.evidence > back.evidence ? forth : back;
    elapsed += since.elapsed;
  }
  if (!(elapsed > 0)) return std::nullopt;
  return logSe3(before.pose.inverse() * h.pose) / elapsed;
}

SearchReport GlobalLocalizer::judge() const {
  SearchReport report;
  report.keyframes = keyframe_count_;
  report.hypotheses = static_cast<int>(hypotheses_.size());
  if (hypotheses_.empty()) return report;
  const Hypothesis& best = hypotheses_.front();
  report.margin = best.total - addClusters(&report);
  const Support support = addMeans(best, &report);
  report.estimate.mean = best.pose;
  report.estimate.covariance = best.history.back().covariance;
  addVariance(kSearchFloor, &report.estimate);
  const double needed_margin = neededMargin(report, support);
  report.convincing =
      isExplained(report, support) && report.margin >= needed_margin && !hasRival(needed_margin);
  report.velocity = velocityOf(best);
  // A new hypothesis was chosen because it fits. Only later images can contradict it.
  constexpr int kFollowed = 2;  // keyframes
  report.converged = report.convincing && keyframe_count_ >= map_.params().search.min_keyframes &&
                     best.followed >= kFollowed;
  return report;
}

}  // namespace edge_mcl
