#include "edge_mcl/core/likelihood/score_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/image/edge_field.h"

namespace edge_mcl {
namespace {

TEST(RobustLikelihood, ChanceScoresZeroOnAverage) {
  // The distances are drawn from p0, the density of distances by chance. So the mean of the centred
  // log-ratio is zero by construction. With 200,000 draws its standard error is about 0.003, and
  // the tolerance is five times as much.
  LikelihoodParameters params;
  RandomSource random(12);
  for (const double clutter : {0.005, 0.02, 0.1}) {
    double sum = 0;
    constexpr int kDraws = 200000;
    for (int i = 0; i < kDraws; ++i) {
      const double d = -std::log(1 - random.uniform()) / (2 * clutter);
      sum += sampleScore(params, d > 24 ? INFINITY : d, clutter, 24);
    }
    EXPECT_NEAR(sum / kDraws, 0, 0.015) << clutter;
  }
}

/// Without centring, a missing edge scores log(missing_edge) at every density of clutter.
TEST(RobustLikelihood, UncentredAMissingEdgeCostsTheSameOnABareWallAsAmongTexture) {
  const ImageParameters image;
  const LikelihoodParameters params;
  const SearchGeometry search(image);
  const ScoreLevels centred(image, params), uncentred(image, params, false);
  const auto missing = [&](const ScoreLevels& levels, float clutter) {
    return levels.offset() +
           levels.scale() * static_cast<float>(levels.codes(0, clutter)[search.noEdge(0)]);
  };
  for (const float clutter : {0.004F, 0.02F, 0.1F})
    EXPECT_NEAR(missing(uncentred, clutter), std::log(params.missing_edge), uncentred.scale());
  // With centring, a missing edge scores nearly zero on a bare wall: by chance, most samples there,
  // the share exp(-2cs), have no edge.
  EXPECT_NEAR(missing(centred, 0.004F), 0, 0.2);
}

/// The log-ratio r of docs/likelihood.md, written down again.
double logRatio(const LikelihoodParameters& params, double d, double clutter) {
  const double e = params.missing_edge;
  if (std::isinf(d)) return std::log(e);
  const double p0 = 2 * clutter * std::exp(-2 * clutter * d);
  const double p1 = 2 / (std::sqrt(2 * M_PI) * params.sigma) *
                    std::exp(-d * d / (2 * params.sigma * params.sigma));
  return std::log(e + (1 - e) * p1 / p0);
}

/// Mean of the log-ratio when the distance is drawn from p0, by the midpoint rule over the
/// quantiles of p0.
double plainMean(const LikelihoodParameters& params, double clutter, double search_length) {
  constexpr int kParts = 100000;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    const double d = -std::log(1 - (i + 0.5) / kParts) / (2 * clutter);
    sum += logRatio(params, d > search_length ? INFINITY : d, clutter);
  }
  return sum / kParts;
}

LikelihoodParameters paperModel() {
  LikelihoodParameters params;
  params.model = LikelihoodModel::kPaper;
  return params;
}

/// Equation (1).
TEST(SampleScore, OfThePaperIsAGaussianOfTheDistance) {
  LikelihoodParameters params = paperModel();
  params.sigma = 3;
  for (const double clutter : {0.004, 0.1}) {  // clutter has no effect
    EXPECT_DOUBLE_EQ(sampleScore(params, 0, clutter, 24), 1);
    EXPECT_DOUBLE_EQ(sampleScore(params, 3, clutter, 24), std::exp(-0.5));
    EXPECT_DOUBLE_EQ(sampleScore(params, 7, clutter, 24), std::exp(-49 / 18.0));
    EXPECT_EQ(sampleScore(params, INFINITY, clutter, 24), 0);
  }
}

/// The truth is the formula of docs/likelihood.md. At the end of the reach the log-ratio jumps, and
/// the midpoint rule misplaces the jump by at most one part. So its error is below 6 nats times
/// 1e-5.
TEST(SampleScore, OfTheRobustModelIsTheCentredLogRatio) {
  LikelihoodParameters params;
  for (const double sigma : {1.0, 2.0, 5.0})
    for (const double missing : {0.05, 0.35, 0.9})
      for (const double clutter : {0.004, 0.02, 0.15}) {
        params.sigma = sigma;
        params.missing_edge = missing;
        const double mean = plainMean(params, clutter, 24);
        EXPECT_NEAR(meanLogRatioByChance(params, clutter, 24), mean, 1e-4);
        for (const double d : {0.0, 0.5, 2.0, 9.0, 24.0, double(INFINITY)})
          EXPECT_NEAR(sampleScore(params, d, clutter, 24), logRatio(params, d, clutter) - mean,
                      1e-4)
              << "distance " << d;
      }
}

/// The mean by chance is minus a Kullback-Leibler divergence, so it is never positive. A match says
/// more on a blank wall than among texture.
TEST(SampleScore, AMatchSaysMoreWhereClutterIsRare) {
  const LikelihoodParameters params;
  double last = INFINITY;
  for (const double clutter : {0.004, 0.01, 0.03, 0.08, 0.15}) {
    EXPECT_LT(meanLogRatioByChance(params, clutter, 24), 0);
    const double match = sampleScore(params, 0, clutter, 24);
    EXPECT_GT(match, 0);
    EXPECT_LT(match, last);
    EXPECT_LT(sampleScore(params, INFINITY, clutter, 24), match);
    last = match;
  }
}

/// The limits are those of docs/likelihood.md.
TEST(UsableClutter, StaysBetweenItsLimits) {
  EXPECT_EQ(usableClutter(0), 0.004);
  EXPECT_EQ(usableClutter(0.02), 0.02);
  EXPECT_EQ(usableClutter(7), 0.15);
}

double decoded(const ScoreLevels& levels, uint8_t code) {
  return levels.offset() + double{levels.scale()} * code;
}

/// Score of a number of steps, from the formula. @param centred see ScoreLevels
double plainScore(const LikelihoodParameters& params, const SearchGeometry& search, int bin,
                  int steps, double clutter, bool centred) {
  const double d = steps == search.noEdge(bin) ? INFINITY : steps * search.stepLength(bin);
  if (params.model == LikelihoodModel::kPaper) return sampleScore(params, d, clutter, 24);
  return centred ? sampleScore(params, d, clutter, search.length()) : logRatio(params, d, clutter);
}

/// A byte is rounded, so the score has an error of half a step of the scale. Densities of clutter
/// are tried in the middle of their level (on the logarithmic scale), so that rounding to levels
/// adds no error.
TEST(ScoreLevels, BytesStandForTheScoresWithinHalfAStep) {
  for (const LikelihoodParameters& params : {paperModel(), LikelihoodParameters()})
    for (const bool centred : {true, false}) {
      const ImageParameters image;
      const SearchGeometry search(image);
      const ScoreLevels levels(image, params, centred);
      ASSERT_EQ(levels.borders().size() + 1, levels.levels());
      EXPECT_TRUE(std::is_sorted(levels.borders().begin(), levels.borders().end()));
      int lowest = 255, highest = 0;
      for (size_t level = 0; level < levels.levels(); ++level)
        for (int bin = 0; bin < search.bins(); ++bin)
          for (int s = 0; s <= search.noEdge(bin); ++s) {
            const int code = levels.codesOfLevel(bin, level)[s];
            lowest = std::min(lowest, code);
            highest = std::max(highest, code);
            if (level == 0 || level + 1 >= levels.levels()) continue;
            const double density =
                std::sqrt(double{levels.borders()[level - 1]} * levels.borders()[level]);
            // 1e-5: single precision of scale, offset and borders.
            ASSERT_NEAR(decoded(levels, levels.codesOfLevel(bin, level)[s]),
                        plainScore(params, search, bin, s, density, centred),
                        levels.scale() / 2 + 1e-5);
          }
      // 0 is kept free for ignored pixels. The other bytes are used up to the ends.
      EXPECT_EQ(lowest, 1);
      EXPECT_EQ(highest, 255);
    }
}

/// The paper's model has one level, because clutter has no effect in it.
TEST(ScoreLevels, OfThePaperHaveOneLevel) {
  const ImageParameters image;
  const SearchGeometry search(image);
  const LikelihoodParameters params = paperModel();
  const ScoreLevels levels(image, params);
  EXPECT_EQ(levels.levels(), 1u);
  for (int bin = 0; bin < search.bins(); ++bin) {
    EXPECT_EQ(levels.codes(bin, 0), levels.codes(bin, 1));
    for (int s = 0; s <= search.noEdge(bin); ++s)
      EXPECT_NEAR(decoded(levels, levels.codes(bin, 0.02F)[s]),
                  plainScore(params, search, bin, s, 0.02, true), levels.scale() / 2 + 1e-5);
  }
}

/// A density of clutter belongs to the level between its borders, however small or large it is.
TEST(ScoreLevels, AnyDensityOfClutterHasALevel) {
  const ScoreLevels levels{ImageParameters(), LikelihoodParameters()};
  const std::vector<float>& borders = levels.borders();
  ASSERT_GT(borders.size(), 1u);
  EXPECT_EQ(levels.codes(3, 0), levels.codesOfLevel(3, 0));
  EXPECT_EQ(levels.codes(3, 1e9F), levels.codesOfLevel(3, borders.size()));
  for (size_t i = 0; i < borders.size(); ++i) {
    EXPECT_EQ(levels.codes(3, borders[i] * 0.999F), levels.codesOfLevel(3, i));
    EXPECT_EQ(levels.codes(3, borders[i] * 1.001F), levels.codesOfLevel(3, i + 1));
  }
}

/// There is an entry for every number of steps, and for "no edge". The shortest and the longest
/// normal that a parameter allows are tried.
TEST(ScoreLevels, HaveAnEntryForEveryNumberOfSteps) {
  for (const int length : {2, 24, 200}) {
    ImageParameters image;
    image.search_length = length;
    const SearchGeometry search(image);
    size_t most = 0;
    for (int bin = 0; bin < search.bins(); ++bin)
      most = std::max(most, size_t{search.noEdge(bin)} + 1);
    EXPECT_EQ(ScoreLevels(image, LikelihoodParameters()).entries(), most);
  }
}

}  // namespace
}  // namespace edge_mcl
