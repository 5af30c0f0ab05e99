// Tests the fit of two systems of coordinates. The truth is the similarity that made the pairs.
#include "edge_mcl/core/recordings/similarity_fit.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

Similarity truth() {
  Similarity s;
  s.rotation = rotationFromAngles(0.05, -0.1, 137 * kDegree);
  s.shift = Eigen::Vector3d(40, -12, 3);
  s.scale = 1.07;
  return s;
}

/// Poses on a curve of 3 m. @param noise m, and 0.5 rad per metre of it
std::vector<PosePair> pairs(size_t count, double noise, uint64_t seed, bool on_a_line = false) {
  RandomSource random(seed);
  std::vector<PosePair> result;
  for (size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(count);
    PosePair pair;
    pair.from.translation() = Eigen::Vector3d(3 * t, on_a_line ? 0 : std::sin(3 * t), 0);
    pair.from.linear() = rotationFromAngles(0.1 * t, 0.2, 2 * t);
    pair.to.translation() =
        truth() * pair.from.translation() +
        noise * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    pair.to.linear() =
        truth().rotation * pair.from.linear() *
        expSo3(0.5 * noise * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    result.push_back(pair);
  }
  return result;
}

void expectTruth(const SimilarityFit& fit, double position, double angle, double scale) {
  const Eigen::Vector3d middle(1.5, 0.5, 0);
  EXPECT_LT((fit.similarity * middle - truth() * middle).norm(), position);
  EXPECT_LT(logSo3(fit.similarity.rotation.transpose() * truth().rotation).norm(), angle);
  EXPECT_NEAR(fit.similarity.scale, truth().scale, scale);
}

TEST(SimilarityFit, IsExactWithoutNoise) {
  for (const bool on_a_line : {false, true}) {
    const SimilarityFit fit = fitSimilarity(pairs(50, 0, 1, on_a_line), false);
    expectTruth(fit, 1e-9, 1e-9, 1e-9);
    EXPECT_EQ(fit.used, 50u);
    EXPECT_LT(fit.disagreement, 1e-6);
  }
}

/// One pair in five is wrong by metres.
TEST(SimilarityFit, WrongPairsAreLeftOut) {
  std::vector<PosePair> some = pairs(100, 0.01, 2);
  RandomSource random(5);
  for (size_t i = 0; i < some.size(); i += 5) {
    some[i].to.translation() += 4 * random.direction();
    some[i].to.linear() = some[i].to.linear() * expSo3(2 * random.direction());
  }
  const SimilarityFit fit = fitSimilarity(some, false);
  EXPECT_EQ(fit.used, 80u);
  expectTruth(fit, 0.01, 0.005, 0.005);
}

/// The noise of the pairs is independent, so the stated deviations, which count ten images as one,
/// must cover the errors. Over 100 seeds the errors of a Gaussian stay below four deviations.
TEST(SimilarityFit, TheUncertaintyCoversTheError) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    const SimilarityFit fit = fitSimilarity(pairs(100, 0.02, seed), false);
    EXPECT_LT(std::abs(fit.similarity.scale - truth().scale), 4 * fit.scale_sigma);
    EXPECT_LT(logSo3(fit.similarity.rotation.transpose() * truth().rotation).norm(),
              4 * fit.rotation_sigma);
  }
}

TEST(SimilarityFit, PosesOfAnotherBodyDisagree) {
  std::vector<PosePair> some = pairs(50, 0, 1);
  for (PosePair& pair : some) pair.to.linear() = pair.to.linear() * opticalOnBody().linear();
  EXPECT_GT(fitSimilarity(some, false).disagreement, 30 * kDegree);
}

TEST(SimilarityFit, TooLittleIsAnError) {
  EXPECT_THROW(fitSimilarity(pairs(9, 0, 1), false), InputError);
  std::vector<PosePair> still = pairs(20, 0, 1);
  for (PosePair& pair : still) pair = still[0];
  EXPECT_THROW(fitSimilarity(still, false), InputError);
  EXPECT_NO_THROW(fitSimilarity(still, true));
}

}  // namespace
}  // namespace edge_mcl
