#include "edge_mcl/core/edges/line_merging.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "support/random_points.h"

namespace edge_mcl {
namespace {

using test::anywhere;
using test::Random;
using test::uniform;

EdgeLine line(const Eigen::Vector3f& start, const Eigen::Vector3f& end,
              EdgeKind kind = EdgeKind::kCrease) {
  EdgeLine result;
  result.start = start;
  result.end = end;
  result.kind = kind;
  return result;
}

/// Whether two lines have the same ends, in any order, up to a tolerance.
bool haveSameEnds(const EdgeLine& a, const EdgeLine& b, double tolerance) {
  const auto apart = [](const Eigen::Vector3f& p, const Eigen::Vector3f& q) {
    return static_cast<double>((p - q).norm());
  };
  return std::min(std::max(apart(a.start, b.start), apart(a.end, b.end)),
                  std::max(apart(a.start, b.end), apart(a.end, b.start))) <= tolerance;
}

/// Random lines are cut into pieces that touch or overlap. The pieces are turned around at random
/// and shuffled. The truth is the lines before the cuts.
TEST(MergeCollinear, PiecesOfALineBecomeTheLineAgain) {
  constexpr double kTolerance = 1e-4;
  constexpr int kLines = 100, kPieces = 6;
  Random random(1);
  std::vector<EdgeLine> whole, pieces;
  for (int i = 0; i < kLines; ++i) {
    const Eigen::Vector3d start = 5 * anywhere(&random), end = 5 * anywhere(&random);
    whole.push_back(line(start.cast<float>(), end.cast<float>()));
    for (int k = 0; k < kPieces; ++k) {
      const double from = std::max(0.0, (k - uniform(&random, 0, 0.5)) / kPieces);
      const double to = (k + 1.0) / kPieces;
      Eigen::Vector3f a = (start + from * (end - start)).cast<float>(),
                      b = (start + to * (end - start)).cast<float>();
      if (uniform(&random, 0, 1) < 0.5) std::swap(a, b);
      pieces.push_back(line(a, b));
    }
  }
  std::shuffle(pieces.begin(), pieces.end(), random);
  EXPECT_EQ(mergeCollinear(&pieces, kTolerance), static_cast<size_t>(kLines * (kPieces - 1)));
  ASSERT_EQ(pieces.size(), whole.size());
  for (const EdgeLine& expected : whole)
    EXPECT_EQ(
        std::count_if(pieces.begin(), pieces.end(),
                      [&](const EdgeLine& l) { return haveSameEnds(l, expected, kTolerance); }),
        1);
}

/// Number of lines that remain of two lines, with a tolerance of 1 mm. A third line far away keeps
/// the mean of all lines away from the two.
size_t remaining(const EdgeLine& a, const EdgeLine& b) {
  std::vector<EdgeLine> lines{a, b, line({3, 40, 7}, {5, 41, 9})};
  const size_t gone = mergeCollinear(&lines, 1e-3);
  EXPECT_EQ(gone + lines.size(), 3u);
  return lines.size() - 1;
}

TEST(MergeCollinear, GapsUpToTheToleranceAreClosed) {
  const EdgeLine first = line({0, 0, 0}, {1, 0, 0});
  EXPECT_EQ(remaining(first, line({1.0009f, 0, 0}, {2, 0, 0})), 1u);
  EXPECT_EQ(remaining(first, line({1.0011f, 0, 0}, {2, 0, 0})), 2u);
  EXPECT_EQ(remaining(first, line({0.2f, 0, 0}, {0.4f, 0, 0})), 1u);    // within the first
  EXPECT_EQ(remaining(first, line({1, 0, 0}, {0, 0, 0})), 1u);          // the same, turned around
  EXPECT_EQ(remaining(first, line({-1, 0, 0}, {-0.0005f, 0, 0})), 1u);  // before the first
}

TEST(MergeCollinear, LinesBesideEachOtherStayApart) {
  const EdgeLine first = line({0, 0, 0}, {1, 0, 0});
  EXPECT_EQ(remaining(first, line({0.5f, 0.0009f, 0}, {2, 0.0009f, 0})), 1u);
  EXPECT_EQ(remaining(first, line({0.5f, 0.0011f, 0}, {2, 0.0011f, 0})), 2u);
  EXPECT_EQ(remaining(first, line({0.5f, -0.5f, 0}, {0.5f, 0.5f, 0})), 2u);  // a cross
  EXPECT_EQ(remaining(first, line({1, 0, 0}, {2, 0.05f, 0})), 2u);           // a bend of 3 degrees
}

/// The longest piece is neither the first nor the last one.
TEST(MergeCollinear, TheUnionIsOfTheKindOfItsLongestPiece) {
  std::vector<EdgeLine> lines{line({0, 0, 0}, {1, 0, 0}, EdgeKind::kBoundary),
                              line({1, 0, 0}, {4, 0, 0}, EdgeKind::kMaterial),
                              line({4, 0, 0}, {6, 0, 0}, EdgeKind::kLine)};
  lines[1].into_a = {0, 1, 0};
  lines[1].into_b = {0, 0, 1};
  lines[1].normal_a = {0, 0, -1};
  lines[1].normal_b = {0, -1, 0};
  const EdgeLine longest = lines[1];
  EXPECT_EQ(mergeCollinear(&lines, 1e-3), 2u);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_TRUE(haveSameEnds(lines[0], line({0, 0, 0}, {6, 0, 0}), 1e-5));  // single precision
  EXPECT_EQ(lines[0].kind, EdgeKind::kMaterial);
  EXPECT_EQ(lines[0].into_a, longest.into_a);
  EXPECT_EQ(lines[0].into_b, longest.into_b);
  EXPECT_EQ(lines[0].normal_a, longest.normal_a);
  EXPECT_EQ(lines[0].normal_b, longest.normal_b);
}

TEST(MergeCollinear, NoneOrOneLineStays) {
  std::vector<EdgeLine> lines;
  EXPECT_EQ(mergeCollinear(&lines, 1e-3), 0u);
  lines.push_back(line({1, 2, 3}, {4, 5, 6}));
  EXPECT_EQ(mergeCollinear(&lines, 1e-3), 0u);
  EXPECT_EQ(lines.size(), 1u);
}

/// Two lines 2 cm apart, each of two pieces that touch. The pieces of a line have a bend of 4e-7
/// radians, which is rounding. The tolerance is 1 mm. The search compares only lines in a common
/// cell of one of two grids. Here the foot points lie on both sides of a border of the first grid,
/// and the directions lie on both sides of a border of the second grid.
TEST(MergeCollinear, DISABLED_APieceOnTheBordersOfBothGridsIsMerged) {
  constexpr float kNoise = 2e-7f;
  std::vector<EdgeLine> lines;
  for (const float side : {1.0f, -1.0f}) {
    const Eigen::Vector3f joint(0.5f, 0.01f, 0);
    lines.push_back(line(side * (joint - Eigen::Vector3f(2, 2 * kNoise, 0)), side * joint));
    lines.push_back(line(side * joint, side * (joint + Eigen::Vector3f(1, -kNoise, 0))));
  }
  EXPECT_EQ(mergeCollinear(&lines, 1e-3), 2u);
  EXPECT_EQ(lines.size(), 2u);
}

/// A long line, and two pieces of another line that touch. The lines lie 5 mm apart, and the
/// tolerance is 1 mm. All of them share a cell in both grids. Only the longest line of a cell is
/// compared with the others, so the two pieces are never compared with each other. The far copy
/// keeps the mean of all lines, which is the centre of the grids, at the origin.
TEST(MergeCollinear, DISABLED_PiecesBesideALongerLineAreMerged) {
  std::vector<EdgeLine> lines;
  for (const float side : {1.0f, -1.0f}) {
    lines.push_back(line({-3, side * 0.002f, side}, {3, side * 0.002f, side}));
    lines.push_back(line({-1, side * 0.007f, side}, {0, side * 0.007f, side}));
    lines.push_back(line({0, side * 0.007f, side}, {1, side * 0.007f, side}));
  }
  EXPECT_EQ(mergeCollinear(&lines, 1e-3), 2u);
  EXPECT_EQ(lines.size(), 4u);
}

/// Sides of a regular polygon with radius 1. Every second side is turned around, because the order
/// of the ends must not matter.
std::vector<EdgeLine> polygon(int sides) {
  const auto corner = [&](int i) {
    const double a = 2 * M_PI * (i % sides) / sides;
    return Eigen::Vector3d(std::cos(a), std::sin(a), 0.5).cast<float>().eval();
  };
  std::vector<EdgeLine> lines;
  lines.reserve(sides);
  for (int i = 0; i < sides; ++i)
    lines.push_back(i % 2 ? line(corner(i), corner(i + 1)) : line(corner(i + 1), corner(i)));
  return lines;
}

/// The sides of a polygon with n corners turn by 360 / n degrees: 32.7 degrees with 11 corners, and
/// 36 degrees with 10 corners.
TEST(GroupCurves, ACurveTurnsByAtMostThirtyFiveDegrees) {
  std::vector<EdgeLine> round = polygon(11), cornered = polygon(10);
  EXPECT_EQ(groupCurves(&round, 1e-4), 1u);
  EXPECT_EQ(groupCurves(&cornered, 1e-4), 10u);
}

TEST(GroupCurves, AtACrossingEveryCurveGoesStraightOn) {
  std::vector<EdgeLine> lines{line({-1, 0, 0}, {0, 0, 0}), line({0, -1, 0}, {0, 0, 0}),
                              line({0, 0, 0}, {1, 0, 0}), line({0, 0, 0}, {0, 1, 0})};
  EXPECT_EQ(groupCurves(&lines, 1e-4), 2u);
  ASSERT_EQ(lines.size(), 4u);
  for (const EdgeLine& l : lines)
    EXPECT_EQ(l.group, std::abs(l.tangent().x()) > 0.5f ? 0u : 1u) << l.tangent().transpose();
}

/// A cell has 4 mm, and its centre is a multiple of 4 mm. So ends at +1 mm and -1 mm share a cell,
/// and ends at +1 mm and +3 mm do not.
TEST(GroupCurves, EndsInOneCellMeet) {
  const auto groups = [](float first_end, float second_start) {
    std::vector<EdgeLine> lines{line({-1, 0, 0}, {first_end, 0, 0}),
                                line({second_start, 0, 0}, {1, 0, 0})};
    return groupCurves(&lines, 1e-3);
  };
  EXPECT_EQ(groups(-0.001f, 0.001f), 1u);
  EXPECT_EQ(groups(0.001f, 0.003f), 2u);
  EXPECT_EQ(groups(-0.1f, 0.1f), 2u);
}

/// Two columns with one rim each and two lines of their own. The sides of the rims come in turns.
TEST(GroupCurves, LinesAreOrderedByGroupAndGroupsAreNumberedFromZero) {
  const std::vector<EdgeLine> rim = polygon(16);
  std::vector<EdgeLine> lines;
  lines.push_back(line({7, 7, 7}, {8, 8, 8}));
  for (const EdgeLine& side : rim)
    for (const float height : {0.0f, 3.0f}) {
      const Eigen::Vector3f up(0, 0, height);
      lines.push_back(line(side.start + up, side.end + up));
    }
  lines.push_back(line({9, 7, 7}, {9, 8, 8}));
  const size_t count = lines.size();
  ASSERT_EQ(groupCurves(&lines, 1e-4), 4u);
  ASSERT_EQ(lines.size(), count);
  std::vector<int> members(4);
  std::vector<std::set<float>> heights(4);
  for (size_t i = 0; i < count; ++i) {
    ASSERT_LT(lines[i].group, 4u);
    EXPECT_GE(lines[i].group, lines[i > 0 ? i - 1 : 0].group);
    ++members[lines[i].group];
    heights[lines[i].group].insert(lines[i].start.z());
  }
  std::sort(members.begin(), members.end());
  EXPECT_EQ(members, (std::vector<int>{1, 1, 16, 16}));
  for (const auto& of_group : heights) EXPECT_EQ(of_group.size(), 1u);
}

TEST(GroupCurves, WithoutLinesThereIsNoGroup) {
  std::vector<EdgeLine> lines;
  EXPECT_EQ(groupCurves(&lines, 1e-4), 0u);
}

}  // namespace
}  // namespace edge_mcl
