#include "edge_mcl/core/edges/line_cuts.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

using Pieces = std::vector<std::array<Eigen::Vector3d, 2>>;

std::vector<EdgeLine> tenMetres() {
  EdgeLine line;
  line.start = {1, 2, 3};
  line.end = {11, 2, 3};
  line.kind = EdgeKind::kCrease;
  return {line};
}

TEST(LineCuts, APieceInTheMiddleLeavesTwoLines) {
  std::vector<EdgeLine> lines = tenMetres();
  cutOut(Pieces{{Eigen::Vector3d(6, 2, 3), Eigen::Vector3d(4, 2, 3)}}, &lines);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NEAR(lines[0].end.x(), 4, 1e-6);
  EXPECT_NEAR(lines[1].start.x(), 6, 1e-6);
  EXPECT_EQ(lines[1].end.x(), 11);
}

TEST(LineCuts, PiecesThatOverlapAreCutOnceAndEndsDisappear) {
  std::vector<EdgeLine> lines = tenMetres();
  cutOut(Pieces{{Eigen::Vector3d(0.999, 2, 3), Eigen::Vector3d(4, 2, 3)},
                {Eigen::Vector3d(3, 2, 3), Eigen::Vector3d(5, 2, 3)},
                {Eigen::Vector3d(8, 2, 3), Eigen::Vector3d(11, 2, 3)}},
         &lines);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR(lines[0].start.x(), 5, 1e-6);
  EXPECT_NEAR(lines[0].end.x(), 8, 1e-6);
}

TEST(LineCuts, AWholeLineDisappears) {
  std::vector<EdgeLine> lines = tenMetres();
  cutOut(Pieces{{Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(11, 2, 3)}}, &lines);
  EXPECT_TRUE(lines.empty());
}

TEST(LineCuts, PiecesBesideTheLineAreIgnored) {
  std::vector<EdgeLine> lines = tenMetres();
  cutOut(Pieces{{Eigen::Vector3d(4, 2.005, 3), Eigen::Vector3d(6, 2.005, 3)},
                {Eigen::Vector3d(4, 2, 3), Eigen::Vector3d(4, 5, 3)},
                {Eigen::Vector3d(20, 2, 3), Eigen::Vector3d(21, 2, 3)}},
         &lines);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].length(), 10);
}

}  // namespace
}  // namespace edge_mcl
