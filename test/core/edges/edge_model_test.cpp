#include "edge_mcl/core/edges/edge_model.h"

#include <gtest/gtest.h>

#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

std::string writeFile(const std::string& name, const std::string& text) {
  std::string file = testing::TempDir() + name;
  std::ofstream(file) << text;
  return file;
}

/// The truth is a box with sides of 1, 2 and 3 m.
TEST(EdgeModel, ABoxHasTwelveCreases) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {1, 2, 3});
  MeshModel mesh = weldMesh(soup, 1e-6, "box");
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  EXPECT_EQ(edges.countOf(EdgeKind::kCrease), 12u);
  EXPECT_EQ(edges.lines.size(), 12u);
  EXPECT_EQ(edges.group_count, 12u);
  EXPECT_NEAR(edges.feature_length, 4 * (1 + 2 + 3), 1e-4);
  // The samples lie in the middles of equal parts of their lines.
  std::vector<uint32_t> seen(edges.lines.size());
  for (const EdgeSegment& segment : edges.segments) {
    const EdgeLine& line = edges.lines[segment.line];
    const double parts = std::round(line.length() / edges.sample_step);
    for (uint32_t i = 0; i < segment.sample_count; ++i) {
      const double share = (seen[segment.line]++ + 0.5) / parts;
      const Eigen::Vector3d expected =
          ((1 - share) * line.start.cast<double>() + share * line.end.cast<double>());
      EXPECT_LT((edges.samplePosition(segment, i) - expected).norm(), 1e-6);
      EXPECT_LE((edges.samplePosition(segment, i) - segment.centre.cast<double>()).norm(),
                segment.radius);
    }
  }
  for (size_t l = 0; l < seen.size(); ++l)
    EXPECT_EQ(seen[l], std::round(edges.lines[l].length() / edges.sample_step));
}

TEST(EdgeModel, SubdividedEdgesBecomeOneLine) {
  // A unit square consists of 10 x 10 cells with two triangles each. Only its four boundary lines
  // may remain.
  MeshSoup soup;
  for (int y = 0; y <= 10; ++y)
    for (int x = 0; x <= 10; ++x) soup.vertices.emplace_back(0.1f * x, 0.1f * y, 0);
  for (uint32_t y = 0; y < 10; ++y)
    for (uint32_t x = 0; x < 10; ++x) {
      const uint32_t a = 11 * y + x;
      soup.triangles.push_back({a, a + 1, a + 12});
      soup.triangles.push_back({a, a + 12, a + 11});
    }
  soup.triangle_material.assign(soup.triangles.size(), 0);
  MeshModel mesh = weldMesh(soup, 1e-6, "grid");
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  EXPECT_EQ(edges.lines.size(), 4u);
  EXPECT_EQ(edges.countOf(EdgeKind::kBoundary), 4u);
  EXPECT_NEAR(edges.feature_length, 4, 1e-4);
}

/// A square consists of two triangles of different materials.
TEST(EdgeModel, MaterialBordersAreEdges) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  soup.triangle_material = {0, 1};
  MeshModel mesh = weldMesh(soup, 1e-6, "two colours");
  EXPECT_EQ(buildEdgeModel(&mesh, {}).countOf(EdgeKind::kMaterial), 1u);
  MapParameters without;
  without.material_borders = false;
  EXPECT_EQ(buildEdgeModel(&mesh, without).countOf(EdgeKind::kMaterial), 0u);
}

/// The column is a prism with 48 corners. Of its 48 upright lines only the two outlines are
/// visible.
TEST(EdgeModel, AColumnShowsTwoOutlinesFromEverySide) {
  MeshModel mesh = test::column(48, 0.3f, 2);
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  EXPECT_EQ(edges.countOf(EdgeKind::kContour), 48u);
  // Each rim is a curve, so its lines form one group.
  EXPECT_EQ(edges.group_count, 2u + 48u);
  const Visibility visibility(mesh, edges, {});
  for (int step = 0; step < 36; ++step) {
    const double a = 0.02 + step * M_PI / 18;
    const Eigen::Vector3d eye(3 * std::cos(a), 3 * std::sin(a), 1);
    const VisibleSet set = visibility.exact(eye);
    std::vector<Eigen::Vector3d> outlines;
    uint32_t last = 0xffffffffu;
    for (const auto& s : set.segments)
      if (const uint32_t l = edges.segments[s.index].line;
          edges.lines[l].kind == EdgeKind::kContour && l != last) {
        last = l;
        outlines.push_back(edges.lines[l].start.cast<double>());
      }
    ASSERT_EQ(outlines.size(), 2u) << "from " << eye.transpose();
    for (const auto& o : outlines) {
      // The tangents from distance D touch a circle of radius r where cos = r / D. The outline is a
      // corner of the prism, at most half the angle of a side (3.75 degrees) away.
      const double cosine = Eigen::Vector2d(o.head<2>())
                                .normalized()
                                .dot(Eigen::Vector2d(eye.head<2>()).normalized());
      EXPECT_NEAR(std::acos(cosine), std::acos(0.1), 3.76 * M_PI / 180);
    }
  }
}

TEST(EdgeModel, AWireframeIsALegalMap) {
  const std::string file =
      writeFile("wire.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 2 0 0\nl 1 2 3\nl 2 4\n");
  MeshModel mesh = loadMesh(file, {});
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  // The lines 1-2 and 2-4 are collinear and touch, so they are one.
  EXPECT_EQ(edges.countOf(EdgeKind::kLine), 2u);
  EXPECT_NEAR(edges.feature_length, 3, 1e-5);
}

}  // namespace
}  // namespace edge_mcl
