#include "edge_mcl/audit/new_lines.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

MappedLine lineOf(const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
  MappedLine line;
  line.start = start;
  line.end = end;
  line.sigma = 0.005;
  line.views = 6;
  return line;
}

/// The first room is 3.95 m x 5 m x 2.6 m, with a corner at the origin.
class NewLines : public testing::Test {
 protected:
  LocalizationMap map_{test::furnishedRooms(), Parameters()};
};

TEST_F(NewLines, AModelLineExplainsALineBesideIt) {
  EXPECT_TRUE(findNewLines({lineOf({0.02, 1, 0.02}, {0.02, 4, 0.02})}, map_).empty());
}

TEST_F(NewLines, ALineAcrossAModelLineIsNotExplained) {
  // It stands on the edge between wall and floor.
  EXPECT_EQ(findNewLines({lineOf({0.5, 1.5, 0}, {0.5, 1.5, 0.6})}, map_).size(), 1u);
}

TEST_F(NewLines, ALineOnAWallIsAMarking) {
  const std::vector<AuditRow> rows = findNewLines({lineOf({0.01, 2, 1.2}, {0.01, 3, 1.2})}, map_);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].verdict, "marking");
  EXPECT_EQ(rows[0].shape, -1);
  EXPECT_TRUE(newObjects(rows).empty());
}

/// Two boxes of which four edges each were found. They stand half a metre apart.
TEST_F(NewLines, LinesThatMeetAreOneObject) {
  std::vector<MappedLine> lines;
  for (const double x : {1.0, 1.9}) {
    const Eigen::Vector3d a(x, 2, 0.5), b(x + 0.4, 2, 0.5), c(x + 0.4, 2.4, 0.5), d(x, 2.4, 0.5);
    lines.push_back(lineOf(a, b));
    lines.push_back(lineOf(b, c));
    lines.push_back(lineOf(c, d));
    lines.push_back(lineOf(d, a));
  }
  const std::vector<NewObject> objects = newObjects(findNewLines(lines, map_));
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].lines, 4u);
  EXPECT_NEAR((objects[0].lowest - Eigen::Vector3d(1, 2, 0.5)).norm(), 0, 1e-9);
  EXPECT_NEAR((objects[1].highest - Eigen::Vector3d(2.3, 2.4, 0.5)).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace edge_mcl
