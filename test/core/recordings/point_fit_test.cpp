// Tests the fit of points in two systems. The truth is the similarity that made the pairs.
#include "edge_mcl/core/recordings/point_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

Similarity truth(double scale) {
  Similarity s;
  s.rotation = rotationFromAngles(0.05, -0.1, 137 * kDegree);
  s.shift = Eigen::Vector3d(40, -12, 3);
  s.scale = scale;
  return s;
}

/// Corners of a house of 10 x 8 x 3 m, or of its plan, with noise.
std::vector<PointPair> corners(const Similarity& s, double noise, RandomSource* random,
                               bool is_plan = false) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < (is_plan ? 4 : 8); ++i) {
    PointPair pair;
    pair.from = Eigen::Vector3d(i & 1 ? 10 : 0, i & 2 ? 8 : 0, i & 4 ? 3 : 0) / s.scale;
    pair.to = s * pair.from +
              noise * Eigen::Vector3d(random->normal(), random->normal(), random->normal());
    pairs.push_back(pair);
  }
  return pairs;
}

TEST(PointFit, FindsTheSimilarityOfExactPoints) {
  RandomSource random(1);
  for (const double scale : {1.0, 0.0254, 3.3})
    for (const bool is_plan : {false, true}) {
      const Similarity s = truth(scale);
      for (const auto& known : {std::optional<double>(), std::optional<double>(scale)}) {
        const PointFit fit = fitPoints(corners(s, 0, &random, is_plan), known);
        EXPECT_LT((fit.similarity.rotation - s.rotation).norm(), 1e-9);
        EXPECT_LT((fit.similarity.shift - s.shift).norm(), 1e-7);
        EXPECT_NEAR(fit.similarity.scale, scale, 1e-9);
        EXPECT_LT(fit.rms, 1e-7);
      }
    }
}

/// Over many seeds the errors must be as large as the standard deviations say.
TEST(PointFit, StandardDeviationsAreTrue) {
  constexpr int kSeeds = 300;
  constexpr double kNoise = 0.02;  // m, per axis
  double position = 0, scale = 0, turn = 0, told_position = 0, told_scale = 0, told_turn = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    RandomSource random(static_cast<uint64_t>(seed));
    const Similarity s = truth(0.0254);
    const std::vector<PointPair> pairs = corners(s, kNoise, &random);
    const PointFit fit = fitPoints(pairs, std::nullopt);
    const Eigen::Vector3d middle = Eigen::Vector3d(5, 4, 1.5) / s.scale;
    position += (fit.similarity * middle - s * middle).squaredNorm() / 3;
    scale += std::pow(fit.similarity.scale - s.scale, 2);
    // The points are farthest from the vertical axis and nearest to the longest one, about which
    // the rotation is worst.
    const Eigen::Vector3d error = logSo3(s.rotation.transpose() * fit.similarity.rotation);
    turn += error.x() * error.x();
    told_position += fit.position_sigma * fit.position_sigma;
    told_scale += fit.scale_sigma * fit.scale_sigma;
    told_turn += fit.rotation_sigma * fit.rotation_sigma;
  }
  // A sum of 300 squares has a relative standard deviation of sqrt(2 / 300) = 8 %.
  EXPECT_NEAR(position / told_position, 1, 0.25);
  EXPECT_NEAR(scale / told_scale, 1, 0.25);
  EXPECT_NEAR(turn / told_turn, 1, 0.25);
}

TEST(PointFit, AWrongPairHasTheLargestResidual) {
  RandomSource random(3);
  std::vector<PointPair> pairs = corners(truth(1), 0.01, &random);
  pairs[2].to.x() += 1;
  const PointFit fit = fitPoints(pairs, 1.0);
  EXPECT_EQ(std::max_element(fit.residuals.begin(), fit.residuals.end()) - fit.residuals.begin(),
            2);
}

TEST(PointFit, WhatIsOpenIsRefused) {
  RandomSource random(4);
  std::vector<PointPair> pairs = corners(truth(1), 0, &random);
  EXPECT_THROW(fitPoints({pairs[0], pairs[1]}, 1.0), InputError);
  for (PointPair& pair : pairs) pair.from.y() = pair.from.z() = 0;
  EXPECT_THROW(fitPoints(pairs, 1.0), InputError);
  pairs = corners(truth(1), 0, &random);
  pairs[0].to.x() = NAN;
  EXPECT_THROW(fitPoints(pairs, 1.0), InputError);
}

}  // namespace
}  // namespace edge_mcl
