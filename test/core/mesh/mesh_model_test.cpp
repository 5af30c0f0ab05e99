#include "edge_mcl/core/mesh/mesh_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/edges/edge_model.h"
#include "support/error_text.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::expectError;

TEST(EdgeModel, WeldsVerticesAndDropsDegenerateAndDuplicateFaces) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {1, 1, 1});
  // Every triangle has its own vertices, with errors of up to 2e-6 m per axis. One triangle is
  // added twice, and one has no area.
  MeshSoup loose;
  int k = 0;
  for (const auto& t : soup.triangles) {
    const auto base = static_cast<uint32_t>(loose.vertices.size());
    for (uint32_t v : t)
      loose.vertices.push_back(soup.vertices[v] + Eigen::Vector3f::Constant(1e-6f * (k++ % 3)));
    loose.triangles.push_back({base, base + 1, base + 2});
  }
  loose.triangles.push_back(loose.triangles.front());
  loose.triangles.push_back({0, 0, 1});
  loose.triangle_material.assign(loose.triangles.size(), 0);
  MeshModel mesh = weldMesh(loose, 1e-5, "loose box");
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(mesh.report.degenerate_triangles, 1u);
  EXPECT_EQ(mesh.report.duplicate_triangles, 1u);
  EXPECT_EQ(buildEdgeModel(&mesh, {}).countOf(EdgeKind::kCrease), 12u);
}

/// Triangles of half a metre at random places, with vertices of their own. Many vertices lie within
/// the tolerance of each other, on a grid with noise.
MeshSoup crowdedSoup(uint64_t seed) {
  test::Random random(seed);
  MeshSoup soup;
  for (int i = 0; i < 1500; ++i) {
    const auto base = static_cast<uint32_t>(soup.vertices.size());
    const Eigen::Vector3d at = (2 * test::anywhere(&random)).array().round() / 2;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d corner = at + 0.5 * Eigen::Vector3d::Unit(k);
      soup.vertices.push_back((corner + 0.01 * test::anywhere(&random)).cast<float>());
    }
    soup.triangles.push_back({base, base + 1, base + 2});
    soup.triangle_material.push_back(static_cast<uint32_t>(i));
  }
  soup.material_count = 1500;
  return soup;
}

/// Both properties are checked with every pair of vertices. A corner may move by the tolerance at
/// most, and no two vertices that remain may be within the tolerance of each other.
TEST(WeldMesh, VerticesWithinTheToleranceBecomeOne) {
  constexpr double kTolerance = 0.008;
  const MeshSoup soup = crowdedSoup(1);
  const MeshModel mesh = weldMesh(soup, kTolerance, "crowded");
  EXPECT_LT(mesh.vertices.size(), soup.vertices.size() / 2);
  // The distance is computed in single precision from coordinates of up to 2 m.
  constexpr double kRounding = 1e-6;
  ASSERT_EQ(mesh.triangle_material.size(), mesh.triangles.size());
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& before = soup.triangles.at(mesh.triangle_material[i]);
    for (int k = 0; k < 3; ++k)
      EXPECT_LE((mesh.vertices.at(mesh.triangles[i][k]) - soup.vertices[before[k]]).norm(),
                kTolerance + kRounding);
  }
  for (size_t i = 0; i < mesh.vertices.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      ASSERT_GT((mesh.vertices[i] - mesh.vertices[j]).norm(), kTolerance - kRounding);
}

TEST(WeldMesh, WithoutToleranceOnlyEqualVerticesBecomeOne) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1e-6f}, {1, 1, 0}};
  soup.triangles = {{0, 1, 2}, {3, 5, 4}, {3, 6, 4}};
  soup.triangle_material = {0, 0, 0};
  const MeshModel mesh = weldMesh(soup, 0, "test");
  EXPECT_EQ(mesh.report.vertices_read, 7u);
  EXPECT_EQ(mesh.vertices.size(), 5u);
  EXPECT_EQ(mesh.triangles.size(), 3u);
}

/// The triangles differ in their winding and in the vertex that comes first. The first triangle
/// stays, with its winding and its material.
TEST(WeldMesh, OfTrianglesWithTheSameVerticesTheFirstOneStays) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
  soup.triangles = {{0, 1, 2}, {2, 0, 1}, {2, 1, 0}, {0, 1, 3}};
  soup.triangle_material = {3, 1, 2, 0};
  soup.material_count = 4;
  const MeshModel mesh = weldMesh(soup, 1e-6, "test");
  EXPECT_EQ(mesh.report.duplicate_triangles, 2u);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangle_material, (std::vector<uint32_t>{3, 0}));
  const auto& t = mesh.triangles[0];
  const Eigen::Vector3f normal =
      (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
  EXPECT_EQ(normal, Eigen::Vector3f(0, 0, 1));
}

/// The triangle is 1 m long. Its height decides whether it has a usable normal.
TEST(WeldMesh, ATriangleThatIsFlatterThanTheToleranceIsDropped) {
  for (const double height : {0.5e-3, 2e-3}) {
    MeshSoup soup;
    soup.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5f, static_cast<float>(height), 0}, {0, 1, 1}};
    soup.triangles = {{0, 1, 2}, {0, 1, 3}};
    soup.triangle_material = {0, 0};
    EXPECT_EQ(weldMesh(soup, 1e-3, "test").report.degenerate_triangles, height < 1e-3 ? 1u : 0u);
  }
}

TEST(WeldMesh, LinesKeepTheirEndsAndThoseWithoutLengthAreDropped) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 2, 3}, {1, 2, 3.0005f}, {9, 9, 9}};
  soup.lines = {{0, 1}, {1, 2}, {2, 3}};
  const MeshModel mesh = weldMesh(soup, 1e-3, "test");
  EXPECT_EQ(mesh.report.zero_length_lines, 1u);
  ASSERT_EQ(mesh.lines.size(), 2u);
  EXPECT_EQ(mesh.vertices.size(), 3u);
  EXPECT_EQ(mesh.vertices[mesh.lines[0][1]], soup.vertices[1]);
  EXPECT_EQ(mesh.vertices[mesh.lines[1][0]], soup.vertices[1]);  // vertex 2 became vertex 1
  EXPECT_EQ(mesh.vertices[mesh.lines[1][1]], soup.vertices[3]);
}

/// A vertex that belongs to no element does not count for the bounds.
TEST(WeldMesh, TheBoundsHoldAllElementsAndNothingElse) {
  MeshSoup soup;
  test::addBox(&soup, {-1, 2, -3}, {2, 6, 9});
  soup.vertices.emplace_back(100, 100, 100);
  const MeshModel mesh = weldMesh(soup, 1e-6, "test");
  EXPECT_EQ(mesh.lowest, Eigen::Vector3f(-1, 2, -3));
  EXPECT_EQ(mesh.highest, Eigen::Vector3f(2, 6, 9));
  EXPECT_DOUBLE_EQ(mesh.diagonal(), 13);  // 3, 4, 12
}

TEST(WeldMesh, MissingColoursBecomeGrey) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {1, 1, 1}, 2);
  soup.material_count = 3;
  soup.material_colors = {{1, 0, 0}};
  const MeshModel mesh = weldMesh(soup, 1e-6, "test");
  ASSERT_EQ(mesh.material_colors.size(), 3u);
  EXPECT_EQ(mesh.material_colors[0], Eigen::Vector3f(1, 0, 0));
  for (const int i : {1, 2}) {
    const Eigen::Vector3f& c = mesh.material_colors[i];
    EXPECT_TRUE(c.x() == c.y() && c.y() == c.z() && c.x() > 0 && c.x() < 1);
  }
}

TEST(WeldMesh, AVertexThatIsNotFiniteOrAbsurdIsAnErrorWithItsNumber) {
  for (const float bad : {NAN, INFINITY, -INFINITY, 1.1e6f, -1e30f}) {
    MeshSoup soup;
    test::addBox(&soup, {0, 0, 0}, {1, 1, 1});
    soup.vertices[5].y() = bad;
    expectError<InputError>("the box: vertex 5 ", [&] { weldMesh(soup, 1e-6, "the box"); });
  }
}

TEST(WeldMesh, AModelWithoutUsableElementIsAnError) {
  expectError<InputError>("nothing: ", [] { weldMesh({}, 1e-6, "nothing"); });
  MeshSoup flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.triangles = {{0, 1, 2}};
  flat.triangle_material = {0};
  flat.lines = {{1, 1}};
  expectError<InputError>("no usable face or line", [&] { weldMesh(flat, 1e-6, "flat"); });
}

}  // namespace
}  // namespace edge_mcl
