#include "edge_mcl/localization/search/ranked_poses.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace edge_mcl {

std::vector<double> placeProbabilities(const std::vector<double>& scores) {
  // Fitted by bench/where, see docs/decisions/search-single-image.md.
  constexpr double kTemperature = 80;  // nats
  constexpr double kNone = 480;        // nats
  const double best =
      scores.empty() ? kNone : std::max(kNone, *std::max_element(scores.begin(), scores.end()));
  std::vector<double> result;
  double sum = 0;
  const auto add = [&](double score) {
    result.push_back(std::exp((score - best) / kTemperature));
    sum += result.back();
  };
  std::for_each(scores.begin(), scores.end(), add);
  add(kNone);
  for (double& p : result) p /= sum;
  return result;
}

RankedPoses rankPoses(PoseSearch* search, const std::vector<CameraView>& views,
                      const std::optional<UpReading>& up, const std::optional<SearchRegion>& region,
                      size_t most, RandomSource* random) {
  std::vector<Pose> starts = search->lookedUp(views, up, region);
  if (starts.empty()) starts = search->everywhere(views, up, random, region);
  const SearchViews seen = search->prepare(views);
  std::vector<FoundPose> found(starts.size());
  tbb::parallel_for(size_t{0}, starts.size(), [&](size_t i) {
    found[i] = search->sharpen(seen, starts[i], search->looseAround(starts[i], up));
  });
  std::stable_sort(found.begin(), found.end(), [](const FoundPose& a, const FoundPose& b) {
    return a.log_likelihood > b.log_likelihood;
  });
  RankedPoses ranked;
  std::vector<double> scores;
  for (const FoundPose& f : found) {
    if (ranked.poses.size() >= most) break;
    if (!search->admits(views, f.pose) ||
        std::any_of(ranked.poses.begin(), ranked.poses.end(),
                    [&](const RankedPose& r) { return isNear(r.found.pose, f.pose, kSamePlace); }))
      continue;
    ranked.poses.push_back({f, 0});
    scores.push_back(f.log_likelihood);
  }
  const std::vector<double> probabilities = placeProbabilities(scores);
  for (size_t i = 0; i < scores.size(); ++i) ranked.poses[i].probability = probabilities[i];
  ranked.none = probabilities.back();
  return ranked;
}

}  // namespace edge_mcl
