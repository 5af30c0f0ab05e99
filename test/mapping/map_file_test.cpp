#include "edge_mcl/mapping/map_file.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

TEST(MapFile, ItsLinesAreEdgesAndItsFacesOnlyHide) {
  const std::string file = testing::TempDir() + "map.obj";
  MeshSoup box;
  test::addBox(&box, {0, 0, 0}, {1, 1, 1});
  const std::vector<MappedLine> lines{{{0, 0, 0}, {1, 0, 0}, 0.004, 5},
                                      {{0, 0, 2}, {1, 0, 2}, 0.015, 4},
                                      {{0, 3, 2}, {1, 3, 2}, 0.5, 4}};
  writeMapFile(file, lines, box, Eigen::Vector3d::Zero(), "a comment");
  MeshModel mesh = loadMesh(file, {});
  EXPECT_EQ(mesh.lines.size(), 3u);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.hides_only, std::vector<bool>(12, true));
  EXPECT_EQ(mesh.report.objects.count("lines_5mm"), 1u);
  EXPECT_EQ(mesh.report.objects.count("lines_20mm"), 1u);
  EXPECT_EQ(mesh.report.objects.count("lines_80mm"), 1u);
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  EXPECT_EQ(edges.countOf(EdgeKind::kLine), 3u);
  EXPECT_EQ(edges.lines.size(), 3u);
}

TEST(MapFile, FacesKeepTheirMillimetresFarFromTheOrigin) {
  const std::string file = testing::TempDir() + "far.obj";
  const Eigen::Vector3d origin(500000, 5400000, 200);
  MeshSoup box;
  test::addBox(&box, {0.1234f, 0, 0}, {1, 1, 1});
  writeMapFile(file, {{origin, origin + Eigen::Vector3d(1, 0, 0), 0.004, 5}}, box, origin, "");
  const MeshModel mesh = loadMesh(file, {});
  EXPECT_NEAR(mesh.lowest.x() + mesh.origin.x(), 500000, 1e-3);
  bool found = false;
  for (const Eigen::Vector3f& v : mesh.vertices)
    found = found || std::abs(v.x() + mesh.origin.x() - 500000.1234) < 1e-3;
  EXPECT_TRUE(found);
}

TEST(MapFile, AFileThatCannotBeWrittenIsAnError) {
  EXPECT_THROW(writeMapFile("/does/not/exist/map.obj", {}, {}, Eigen::Vector3d::Zero(), ""),
               InputError);
}

}  // namespace
}  // namespace edge_mcl
