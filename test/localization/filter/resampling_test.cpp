#include "edge_mcl/localization/filter/resampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double sumOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// The ratio of two weights is the exponential of the difference of their log weights. The offset
/// of 1e5 would overflow or underflow in an exponential of its own.
TEST(Normalize, WeightsHaveTheSumOneWithAnyCommonOffset) {
  for (const double offset : {0.0, 1e5, -1e5}) {
    const std::vector<double> weights =
        normalize({offset, offset + std::log(2), offset + std::log(5)});
    ASSERT_EQ(weights.size(), 3u);
    // At an offset of 1e5 a double has a resolution of 1.5e-11.
    EXPECT_NEAR(weights[0], 0.125, 1e-10);
    EXPECT_NEAR(weights[1], 0.25, 1e-10);
    EXPECT_NEAR(weights[2], 0.625, 1e-10);
    EXPECT_NEAR(sumOf(weights), 1, 1e-14);
  }
}

TEST(Normalize, AnImpossibleParticleGetsNoWeight) {
  EXPECT_EQ(normalize({0, -kInfinity, 0}), (std::vector<double>{0.5, 0, 0.5}));
}

TEST(Normalize, WithoutAFiniteHighestLogWeightAllWeightsAreEqual) {
  const std::vector<double> quarter(4, 0.25);
  EXPECT_EQ(normalize(std::vector<double>(4, -kInfinity)), quarter);
  EXPECT_EQ(normalize({0, kInfinity, 1, 2}), quarter);
}

TEST(EffectiveSampleSize, IsTheNumberOfParticlesThatShareTheWeight) {
  EXPECT_DOUBLE_EQ(effectiveSampleSize(std::vector<double>(8, 0.125)), 8);
  EXPECT_DOUBLE_EQ(effectiveSampleSize({0, 1, 0, 0}), 1);
  EXPECT_DOUBLE_EQ(effectiveSampleSize({0.5, 0, 0.5, 0}), 2);
  EXPECT_DOUBLE_EQ(effectiveSampleSize({0.75, 0.25}), 1.6);  // 1 / (9/16 + 1/16)
}

/// The exponent must leave an effective sample size of a fifth of the 1000 particles.
TEST(Resampling, TemperingKeepsTheEffectiveSampleSize) {
  RandomSource random(33);
  std::vector<double> fixed(1000, 0), likelihood(1000);
  for (double& l : likelihood) l = 50 * random.normal();
  const double t = temperingExponent(fixed, likelihood, 0.2);
  std::vector<double> logs(1000);
  for (int i = 0; i < 1000; ++i) logs[i] = t * likelihood[i];
  EXPECT_NEAR(effectiveSampleSize(normalize(logs)), 200, 2);
  EXPECT_EQ(temperingExponent(fixed, std::vector<double>(1000, 3), 0.2), 1);
  // For Gaussian log-weights of variance v = (50 t)^2 the closed form is ESS/N = exp(-v).
  EXPECT_NEAR(50 * t, std::sqrt(-std::log(0.2)), 0.12);
}

/// Two particles with the log-likelihoods 0 and -L have ESS = (1 + x)^2 / (1 + x^2), where x =
/// exp(-t L). For ESS = 2 f this gives x = (1 - sqrt(1 - (2f - 1)^2)) / (2f - 1).
TEST(Resampling, TheExponentOfTwoParticlesAgreesWithItsClosedForm) {
  for (const double floor_share : {0.55, 0.7, 0.9})
    for (const double l : {5.0, 100.0}) {
      const double a = 2 * floor_share - 1;
      const double exact = -std::log((1 - std::sqrt(1 - a * a)) / a) / l;
      ASSERT_LT(exact, 1);
      const double t = temperingExponent({0, 0}, {0, -l}, floor_share);
      EXPECT_LE(t, exact + 1e-12);
      EXPECT_GE(t, exact - 1e-4);  // the header promises this
    }
}

TEST(Resampling, AWeakLikelihoodIsNotTempered) {
  // The effective sample size is 1.92 of 2 particles at the exponent 1.
  EXPECT_EQ(temperingExponent({0, 0}, {0, -0.41}, 0.9), 1);
}

/// The fixed weights alone have an effective sample size of 1.0 of 4 particles. A likelihood that
/// prefers the heavy particle would make it smaller, and one that prefers the others makes it
/// larger.
TEST(Resampling, AFloorThatTheFixedWeightsMissIsReplacedByTheirOwn) {
  const std::vector<double> fixed{0, -9, -9, -9};
  EXPECT_LT(effectiveSampleSize(normalize(fixed)), 1.01);
  EXPECT_EQ(temperingExponent(fixed, {30, 0, 0, 0}, 0.5), 0);
  EXPECT_EQ(temperingExponent(fixed, {0, 9, 9, 9}, 0.5), 1);
}

TEST(Resampling, SystematicKeepsExpectedNumbers) {
  const std::vector<double> weights{0.1, 0.2, 0.3, 0.4};
  std::vector<int> count(4);
  for (uint32_t i : systematicResample(weights, 1000, 0.37)) ++count[i];
  // The numbers of systematic resampling differ from the expected ones by less than one copy.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(count[i], 1000 * weights[i], 1);
}

/// The truth is the definition: survivor k is the first particle whose cumulative weight exceeds
/// (k + offset) / count. It is found anew for every k.
TEST(Resampling, SurvivorsAgreeWithTheDefinition) {
  RandomSource random(34);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> weights(1 + trial);
    // Every third particle has no weight. The last one has a weight, so that a survivor exists even
    // where the sum of the weights is rounded down.
    for (size_t i = 0; i < weights.size(); ++i) weights[i] = i % 3 == 1 ? 0 : random.uniform();
    weights.back() = 1;
    const double sum = sumOf(weights);
    for (double& w : weights) w /= sum;
    const int count = 1 + static_cast<int>(100 * random.uniform());
    const double offset = random.uniform();
    const std::vector<uint32_t> survivors = systematicResample(weights, count, offset);
    ASSERT_EQ(survivors.size(), static_cast<size_t>(count));
    EXPECT_TRUE(std::is_sorted(survivors.begin(), survivors.end()));
    for (int k = 0; k < count; ++k) {
      double cumulative = 0;
      uint32_t expected = 0;
      while (expected + 1 < weights.size() &&
             cumulative + weights[expected] <= (k + offset) / count)
        cumulative += weights[expected++];
      EXPECT_EQ(survivors[k], expected);
      EXPECT_GT(weights[survivors[k]], 0);
    }
  }
}

TEST(Resampling, OneParticleSurvivesAlone) {
  EXPECT_EQ(systematicResample({1}, 3, 0.999), (std::vector<uint32_t>{0, 0, 0}));
  EXPECT_EQ(systematicResample({0, 0, 1, 0}, 2, 0), (std::vector<uint32_t>{2, 2}));
}

}  // namespace
}  // namespace edge_mcl
