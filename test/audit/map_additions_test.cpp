#include "edge_mcl/audit/map_additions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

AuditRow newLine(const Eigen::Vector3d& start, const Eigen::Vector3d& end,
                 const std::string& verdict) {
  AuditRow row;
  row.part = AuditRow::Part::kNew;
  row.start = start;
  row.end = end;
  row.verdict = verdict;
  return row;
}

/// A box stands in the first of the furnished rooms, 3.95 m x 5 m x 2.6 m. The model lacks it.
class Additions : public testing::Test {
 protected:
  Additions() {
    test::addBox(&fused_, {1, 2.5f, 0}, {1.5f, 3, 0.6f});
    test::addBox(&fused_, {0, 0, 0}, {8, 5, 2.6f}, 0, true);    // the room, as the model has it
    rows_ = {newLine({1, 2.5, 0.6}, {1.5, 2.5, 0.6}, "new"),    // of the box
             newLine({2.5, 2, 0.9}, {3, 2, 0.9}, "new"),        // of somebody who went away
             newLine({1.2, 2.5, 0.6}, {1.2, 4.9, 0.6}, "new"),  // mostly outside the box
             newLine({0, 2, 1.2}, {0, 3, 1.2}, "marking")};
  }

  LocalizationMap map_{test::furnishedRooms(), Parameters()};
  StandingThing thing_{3, {Eigen::Vector3d(1.05, 2.55, 0.1), Eigen::Vector3d(1.5, 3, 0.6)}, 40};
  MeshSoup fused_;
  std::vector<AuditRow> rows_;
};

TEST_F(Additions, AThingTakesTheLinesAndFacesInItsBox) {
  const MapAdditions additions = additionsOf({thing_}, rows_, fused_, map_);
  ASSERT_EQ(additions.things.size(), 1u);
  EXPECT_EQ(additions.things[0].lines.size(), 1u);
  // The lowest faces lie on the floor, which the model has.
  EXPECT_EQ(additions.things[0].faces.triangles.size(), 10u);
  EXPECT_EQ(additions.things[0].faces.vertices.size(), 8u);
  EXPECT_EQ(additions.markings.size(), 1u);
}

TEST_F(Additions, NothingIsOfferedWithoutAThing) {
  const MapAdditions additions = additionsOf({}, {rows_.begin(), rows_.end() - 1}, fused_, map_);
  EXPECT_TRUE(additions.things.empty());
  EXPECT_TRUE(additions.markings.empty());
}

TEST_F(Additions, AThingWithoutLinesAndFacesIsLeftOut) {
  StandingThing elsewhere = thing_;
  elsewhere.box.translate(Eigen::Vector3d(4, 1, 0.8));
  const MapAdditions additions = additionsOf({elsewhere}, rows_, fused_, map_);
  EXPECT_TRUE(additions.things.empty());
  EXPECT_EQ(additions.without_parts, 1u);
}

TEST_F(Additions, AMapTakesTheFile) {
  const std::string file = testing::TempDir() + "additions.obj";
  writeAdditions(file, additionsOf({thing_}, rows_, fused_, map_), map_.mesh().origin);
  EXPECT_TRUE(isAdditionsFile(file));
  const std::string model = testing::TempDir() + "room.obj";
  std::ofstream(model) << "o floor\nv 0 0 0\nv 8 0 0\nv 0 5 0\nf 1 2 3\n";
  EXPECT_FALSE(isAdditionsFile(model));
  MapParameters params;
  params.additions = file;
  MeshModel mesh = loadMesh(model, params);
  EXPECT_EQ(mesh.triangles.size(), 11u);
  EXPECT_EQ(mesh.lines.size(), 2u);
  EXPECT_EQ(std::count(mesh.hides_only.begin(), mesh.hides_only.end(), true), 10);
  // The creases of hiding faces are no lines.
  EXPECT_EQ(buildEdgeModel(&mesh, {}).countOf(EdgeKind::kLine), 2u);
  EXPECT_EQ(buildEdgeModel(&mesh, {}).countOf(EdgeKind::kCrease), 0u);
  params.exclude = "thing_3_*";
  const MeshModel without = loadMesh(model, params);
  EXPECT_EQ(without.lines.size(), 1u);
  EXPECT_TRUE(without.hides_only.empty());
  EXPECT_EQ(highestThing(mesh.report.objects), 3);
  EXPECT_EQ(highestThing(without.report.objects), 0);
}

/// Depth is off by centimetres. A line behind its wall would never be seen.
TEST_F(Additions, MarkingsAreMovedOntoTheSurface) {
  rows_ = {newLine({-0.03, 2, 1.2}, {0.02, 3, 1.2}, "marking")};
  const MapAdditions additions = additionsOf({}, rows_, fused_, map_);
  ASSERT_EQ(additions.markings.size(), 1u);
  EXPECT_LT((additions.markings[0][0] - Eigen::Vector3d(0, 2, 1.2)).norm(), 1e-6);
  EXPECT_LT((additions.markings[0][1] - Eigen::Vector3d(0, 3, 1.2)).norm(), 1e-6);
}

}  // namespace
}  // namespace edge_mcl
