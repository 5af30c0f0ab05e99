#include "edge_mcl/core/edges/covered_edges.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// Adds a rectangle with the corner `at` and the sides `u` and `v`. Its front is where u x v
/// points.
void addRectangle(MeshSoup* soup, const Eigen::Vector3f& at, const Eigen::Vector3f& u,
                  const Eigen::Vector3f& v, uint32_t material = 0) {
  const auto first = static_cast<uint32_t>(soup->vertices.size());
  for (const Eigen::Vector3f& corner :
       {at, Eigen::Vector3f(at + u), Eigen::Vector3f(at + u + v), Eigen::Vector3f(at + v)})
    soup->vertices.push_back(corner);
  soup->triangles.push_back({first, first + 1, first + 2});
  soup->triangles.push_back({first, first + 2, first + 3});
  soup->triangle_material.insert(soup->triangle_material.end(), 2, material);
  soup->material_count = std::max(soup->material_count, material + 1);
}

double edgeLength(MeshSoup soup, bool seams = false) {
  MeshModel mesh = weldMesh(std::move(soup), 1e-6, "test");
  MapParameters params;
  params.seams = seams;
  return buildEdgeModel(&mesh, params).feature_length;
}

/// A wall of 5 x 3 m with a window of 2 x 1 m is cut into four panels whose corners do not meet.
/// The truth is the outline of wall and window: 16 m + 6 m. The bounds of the pieces are found to
/// 12 bisections of 3 cm, which is 0.01 mm.
TEST(CoveredEdges, AWallOfPanelsHasNoSeams) {
  MeshSoup wall;
  const Eigen::Vector3f x(1, 0, 0), z(0, 0, 1);
  addRectangle(&wall, {0, 0, 0}, 5 * x, z);        // sill
  addRectangle(&wall, {0, 0, 2}, 5 * x, z);        // lintel
  addRectangle(&wall, {0, 0, 1}, 1.5f * x, z);     // left
  addRectangle(&wall, {3.5f, 0, 1}, 1.5f * x, z);  // right
  EXPECT_NEAR(edgeLength(wall), 16 + 6, 1e-3);
  EXPECT_NEAR(edgeLength(wall, true), 16 + 6 + 6, 1e-3);  // and 3 m of seam at sill and lintel each
  // The winding of a face does not matter.
  std::swap(wall.triangles[2][0], wall.triangles[2][1]);
  std::swap(wall.triangles[3][0], wall.triangles[3][1]);
  EXPECT_NEAR(edgeLength(wall), 16 + 6, 1e-3);
}

/// Two boxes of 1 x 1 x 1 m stand side by side. The truth is the edges of one box of 2 x 1 x 1 m.
TEST(CoveredEdges, TwoBodiesThatTouchHaveTheEdgesOfOne) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {1, 1, 1});
  test::addBox(&soup, {1, 0, 0}, {2, 1, 1});
  EXPECT_NEAR(edgeLength(soup), 4 * (2 + 1 + 1), 1e-3);
  // A lower box leaves an edge where it ends: the edges of an L of 2 x 1 x 1 m with a step of 0.4
  // m.
  MeshSoup step;
  test::addBox(&step, {0, 0, 0}, {1, 1, 1});
  test::addBox(&step, {1, 0, 0}, {2, 1, 0.6f});
  EXPECT_NEAR(edgeLength(step), 2 * (2 + 1 + 1 + 0.4 + 1 + 0.6) + 6 * 1, 1e-3);
}

/// A poster of another material lies on a wall. Its outline of 2 m is an edge.
TEST(CoveredEdges, APosterOnAWallKeepsItsOutline) {
  MeshSoup soup;
  addRectangle(&soup, {0, 0, 0}, {3, 0, 0}, {0, 0, 3}, 0);
  addRectangle(&soup, {1, -0.0005f, 1}, {0.5f, 0, 0}, {0, 0, 0.5f}, 1);
  EXPECT_NEAR(edgeLength(soup), 12 + 2, 1e-3);
}

/// Two rooms that are modelled from inside share the plane of a wall without thickness. Each keeps
/// its twelve edges; four of them are common.
TEST(CoveredEdges, RoomsBackToBackKeepTheirEdges) {
  MeshSoup soup;
  const auto addRoom = [&](float x0, float x1) {
    const auto first = static_cast<uint32_t>(soup.triangles.size());
    test::addBox(&soup, {x0, 0, 0}, {x1, 4, 3});
    for (size_t i = first; i < soup.triangles.size(); ++i)
      std::swap(soup.triangles[i][0], soup.triangles[i][1]);
  };
  addRoom(0, 5);
  addRoom(5, 9);
  const double wall = 2 * (4 + 3);
  EXPECT_NEAR(edgeLength(soup), 4 * (5 + 4 + 3) + 4 * (4 + 4 + 3) - wall, 1e-3);
}

/// Surfaces of added things stand in both rooms. A ray from the wall meets their backs, as inside a
/// body.
TEST(CoveredEdges, HidingFacesBuryNoEdge) {
  MeshSoup soup;
  for (const float x : {0.f, 5.f}) {
    const size_t first = soup.triangles.size();
    test::addBox(&soup, {x, 0, 0}, {x + 5, 4, 3});
    for (size_t i = first; i < soup.triangles.size(); ++i)
      std::swap(soup.triangles[i][0], soup.triangles[i][1]);
  }
  const double length = edgeLength(soup);
  soup.hides_only.assign(soup.triangles.size(), false);
  addRectangle(&soup, {4, 0, 0}, {0, 0, 3}, {0, 4, 0});  // its front looks away from the wall
  addRectangle(&soup, {6, 0, 0}, {0, 4, 0}, {0, 0, 3});
  soup.hides_only.resize(soup.triangles.size(), true);
  EXPECT_NEAR(edgeLength(soup), length, 1e-3);
}

TEST(CoveredEdges, ExplicitLinesStay) {
  MeshSoup soup;
  addRectangle(&soup, {0, 0, 0}, {3, 0, 0}, {0, 0, 3});
  soup.vertices.emplace_back(1, 0, 1);
  soup.vertices.emplace_back(2, 0, 1);
  soup.lines.push_back({4, 5});
  EXPECT_NEAR(edgeLength(soup), 12 + 1, 1e-3);
}

}  // namespace
}  // namespace edge_mcl
