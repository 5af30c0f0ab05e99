#include "edge_mcl/localization/filter/contrast.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {

double contrastOf(const LocalizationMap& map, const std::vector<CameraView>& views,
                  const Pose& pose) {
  // Turned little enough to see the same part of the model, and far enough to fit none of its
  // lines. A turn about the camera does not move it, so one visible set serves all poses. They are
  // the same for every image.
  constexpr int kCount = 64;
  constexpr double kLittle = 4 * kDegree, kMuch = 10 * kDegree;
  constexpr uint64_t kSeed = 77;
  const Pose& T_base_camera = views.front().T_base_camera;
  RandomSource random(kSeed);
  std::vector<Pose> poses{pose};
  for (int i = 0; i < kCount; ++i) {
    Pose turn = Pose::Identity();
    const double angle = kLittle + (kMuch - kLittle) * random.uniform();
    turn.linear() = expSo3(angle * random.direction());
    poses.push_back(normalized(pose * T_base_camera * turn * T_base_camera.inverse()));
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
