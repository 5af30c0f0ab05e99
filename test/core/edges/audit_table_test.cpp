#include "edge_mcl/core/edges/audit_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"
#include "support/error_text.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

class AuditTable : public test::WithFolder {};

AuditRow rowOf(AuditRow::Part part, const Eigen::Vector3d& start, const Eigen::Vector3d& end,
               double confidence) {
  AuditRow row;
  row.part = part;
  row.start = start;
  row.end = end;
  row.confidence = confidence;
  row.verdict = "gone";
  return row;
}

void write(const std::string& file, const std::string& text) { std::ofstream(file) << text; }

const Eigen::Vector3d kCupboardLow(2.9, 4.2, 0), kCupboardHigh(3.8, 4.9, 1.9);

TEST_F(AuditTable, IsReadAsWritten) {
  const std::string file = path("audit.csv");
  AuditRow row = rowOf(AuditRow::Part::kNew, {500000.1234, -2, 3}, {4, 5, 6.5}, 0.25);
  row.shape = 7;
  row.viewpoints = 12;
  row.shown = 0.5;
  row.by_chance = 0.125;
  row.verdict = "new";
  writeAuditTable(file, {row, rowOf(AuditRow::Part::kShape, {0, 0, 0}, {1, 1, 1}, 0)});
  const std::vector<AuditRow> rows = readAuditTable(file);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].part, AuditRow::Part::kNew);
  EXPECT_EQ(rows[0].start, row.start);
  EXPECT_EQ(rows[0].end, row.end);
  EXPECT_EQ(rows[0].shape, 7);
  EXPECT_EQ(rows[0].viewpoints, 12);
  EXPECT_EQ(rows[0].shown, 0.5);
  EXPECT_EQ(rows[0].by_chance, 0.125);
  EXPECT_EQ(rows[0].confidence, 0.25);
  EXPECT_EQ(rows[0].verdict, "new");
  EXPECT_EQ(rows[1].part, AuditRow::Part::kShape);
}

TEST_F(AuditTable, BadTablesAreRefusedWithTheirLine) {
  const std::string file = path("audit.csv");
  const std::string names =
      "part,x1,y1,z1,x2,y2,z2,shape,viewpoints,shown,by_chance,confidence,verdict\n";
  EXPECT_NE(test::errorText<InputError>([&] { readAuditTable(file); }).find("cannot be read"),
            std::string::npos);
  write(file, "");
  EXPECT_NE(test::errorText<InputError>([&] { readAuditTable(file); }).find("not a table"),
            std::string::npos);
  for (const char* row : {"line,0,0,0,1,1,1,0,3,1,0,nan,gone", "line,0,0,0,1,1,1,0,3,1,0,2,gone",
                          "wall,0,0,0,1,1,1,0,3,1,0,0,gone", "line,0,0,0,1,1,1,0,3,1,0,0",
                          "line,0,0,0,1,1,1x,0,3,1,0,0,gone"}) {
    write(file, names + "line,0,0,0,1,1,1,0,3,1,0,0,gone\r\n" + row + "\n");
    EXPECT_NE(test::errorText<InputError>([&] { readAuditTable(file); }).find("audit.csv:3:"),
              std::string::npos)
        << row;
  }
}

/// The cupboard is a box of 12 triangles and 12 edges.
TEST_F(AuditTable, ADoubtedShapeIsLeftOutOfTheMap) {
  const std::string file = path("audit.csv");
  // An edge of the cupboard goes with its shape. It is no line of the table that the model lacks.
  AuditRow shape = rowOf(AuditRow::Part::kShape, kCupboardLow, kCupboardHigh, 0.2);
  AuditRow edge = rowOf(AuditRow::Part::kLine, kCupboardLow, {2.9, 4.2, 1.9}, 0.2);
  shape.shape = edge.shape = 6;
  writeAuditTable(file, {edge, shape});
  Parameters params;
  const LocalizationMap whole(test::furnishedRooms(), params);
  params.map.confidence = file;
  const LocalizationMap without(test::furnishedRooms(), params);
  EXPECT_EQ(without.mesh().triangles.size(), whole.mesh().triangles.size() - 12);
  EXPECT_EQ(without.edges().countOf(EdgeKind::kCrease),
            whole.edges().countOf(EdgeKind::kCrease) - 12);
  ASSERT_EQ(without.mesh().report.warnings.size(), 1u);
  EXPECT_EQ(without.mesh().report.warnings[0], "map.confidence leaves out 1 shapes");
  // What the cupboard hid is in view now: the edge between floor and wall behind it.
  const auto sees = [](const LocalizationMap& map) {
    const VisibleSet set = map.visibility().exact({2, 2, 1.4});
    return std::any_of(set.segments.begin(), set.segments.end(), [&](const auto& s) {
      const Eigen::Vector3f c = set.edgeSegment(s).centre;
      return c.x() > 3.0f && c.x() < 3.7f && c.y() > 4.99f && c.z() < 0.01f;
    });
  };
  EXPECT_FALSE(sees(whole));
  EXPECT_TRUE(sees(without));
  params.map.min_confidence = 0.1;
  EXPECT_EQ(LocalizationMap(test::furnishedRooms(), params).mesh().triangles.size(),
            whole.mesh().triangles.size());
}

TEST_F(AuditTable, TheOriginOfTheMapCounts) {
  MeshModel mesh = test::furnishedRooms();
  mesh.origin = {500000, 5400000, 200};
  leaveOutDoubted(
      {rowOf(AuditRow::Part::kShape, kCupboardLow + mesh.origin, kCupboardHigh + mesh.origin, 0)},
      0.5, &mesh);
  EXPECT_EQ(mesh.triangles.size(), test::furnishedRooms().triangles.size() - 12);
}

TEST_F(AuditTable, AShapeThatTheModelLacksIsToldAndNothingIsDropped) {
  MeshModel mesh = test::furnishedRooms();
  const size_t before = mesh.triangles.size();
  leaveOutDoubted({rowOf(AuditRow::Part::kShape, {0, 0, 0}, {0.5, 0.5, 0.5}, 0)}, 0.5, &mesh);
  EXPECT_EQ(mesh.triangles.size(), before);
  ASSERT_EQ(mesh.report.warnings.size(), 1u);
  EXPECT_NE(mesh.report.warnings[0].find("another model"), std::string::npos);
}

}  // namespace
}  // namespace edge_mcl
