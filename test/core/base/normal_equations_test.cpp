#include "edge_mcl/core/base/normal_equations.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

/// Every part is counted with numbers of its own, so that a part that is left out or counted twice
/// is noticed.
TEST(NormalEquations, SumsOfPartsAreTheSumOfTheWhole) {
  RandomSource random(1);
  NormalEquations whole, sum;
  for (int part = 0; part < 4; ++part) {
    NormalEquations equations;
    for (int row = 0; row < 5; ++row) {
      const Twist j = random.normalTwist();
      const double residual = random.normal();
      for (NormalEquations* n : {&equations, &whole}) {
        n->h += j * j.transpose();
        n->g += j * residual;
        n->matched += 1;
        n->used += 3;
        n->matched_points += 5;
        n->used_points += 7;
      }
    }
    sum += equations;
  }
  // The order of the additions differs, so the last bits differ.
  EXPECT_LT((sum.h - whole.h).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((sum.g - whole.g).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(sum.matched, 20 * 1);
  EXPECT_EQ(sum.used, 20 * 3);
  EXPECT_EQ(sum.matched_points, 20 * 5);
  EXPECT_EQ(sum.used_points, 20 * 7);
}

TEST(NormalEquations, ASumBeginsAtZero) {
  const NormalEquations none;
  EXPECT_TRUE(none.h.isZero(0));
  EXPECT_TRUE(none.g.isZero(0));
  EXPECT_EQ(none.matched + none.used + none.matched_points + none.used_points, 0);
}

}  // namespace
}  // namespace edge_mcl
