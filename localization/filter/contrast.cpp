#include "edge_mcl/localization/filter/contrast.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {

double contrastOf(const LocalizationMap& map, const std::vector<CameraView>& views,
                  const Pose& pose) {
  // Poses near enough to see the same part of the model, and far enough to fit none of its lines.
  // They are the same for every image.
  constexpr int kCount = 64;
  constexpr double kNear = 0.15, kFar = 0.5;  // m
  constexpr double kLittle = 4 * kDegree, kMuch = 10 * kDegree;
  constexpr uint64_t kSeed = 77;
  RandomSource random(kSeed);
  std::vector<Pose> poses{pose};
  for (int i = 0; i < kCount; ++i) {
    Twist away;
    away.head<3>() = (kNear + (kFar - kNear) * random.uniform()) * random.direction();
    away.tail<3>() = (kLittle + (kMuch - kLittle) * random.uniform()) * random.direction();
    poses.push_back(pose * expSe3(away));
  }
  const std::vector<PoseScore> scores = map.evaluate(views, poses);
  if (!(scores.front().line_count > 0)) return 0;
  double sum = 0, squares = 0;
  for (size_t i = 1; i < scores.size(); ++i) {
    const double score = scores[i].scorePerLine();
    sum += score;
    squares += score * score;
  }
  const double mean = sum / kCount;
  // Where no pose sees a line, the scores do not differ at all.
  const double least = map.params().likelihood.model == LikelihoodModel::kRobust ? 0.2 : 0.005;
  const double sigma = std::sqrt(std::max(least * least, squares / kCount - mean * mean));
  return (scores.front().scorePerLine() - mean) / sigma;
}

}  // namespace edge_mcl
