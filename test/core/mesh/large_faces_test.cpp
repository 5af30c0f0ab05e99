#include "edge_mcl/core/mesh/large_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/mesh/flat_rectangles.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// A wall in the plane x = 0 from tiles of `step` by `step` metres. Tiles for which `hole` holds
/// are missing.
template <class Hole>
MeshModel tiledWall(int columns, int rows, float step, Hole&& hole) {
  MeshSoup soup;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      if (hole(c, r)) continue;
      const auto base = static_cast<uint32_t>(soup.vertices.size());
      for (const auto& [y, z] : {std::pair{c, r}, {c + 1, r}, {c + 1, r + 1}, {c, r + 1}})
        soup.vertices.emplace_back(0.0f, step * static_cast<float>(y),
                                   step * static_cast<float>(z));
      soup.triangles.push_back({base, base + 1, base + 2});
      soup.triangles.push_back({base, base + 2, base + 3});
      soup.triangle_material.insert(soup.triangle_material.end(), 2, 0);
    }
  return weldMesh(std::move(soup), 1e-6, "wall");
}

double areaOf(const Rectangle& r) { return (r[1] - r[0]).cross(r[3] - r[0]).norm(); }

TEST(FlatRectangles, AWallOfManyTrianglesIsOneRectangle) {
  const MeshModel wall = tiledWall(13, 7, 0.37f, [](int, int) { return false; });
  const std::vector<Rectangle> found = flatRectangles(wall, 0.5);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(areaOf(found[0]), 13 * 7 * 0.37 * 0.37, 1e-4);
}

/// 6 x 3 m with a doorway of 1 x 2 m at y = 2: beside it 2 x 3 m and 3 x 3 m, above it 1 x 1 m.
TEST(FlatRectangles, AWallWithADoorwayIsThree) {
  const MeshModel wall =
      tiledWall(12, 6, 0.5f, [](int c, int r) { return (c == 4 || c == 5) && r < 4; });
  const std::vector<Rectangle> found = flatRectangles(wall, 0.5);
  double area = 0;
  for (const Rectangle& r : found) {
    area += areaOf(r);
    double low = 1e9, high = -1e9, bottom = 1e9;
    for (const Eigen::Vector3d& p : r) {
      low = std::min(low, p.y());
      high = std::max(high, p.y());
      bottom = std::min(bottom, p.z());
    }
    EXPECT_FALSE(low < 3 - 1e-6 && high > 2 + 1e-6 && bottom < 2 - 1e-6) << "covers the doorway";
  }
  EXPECT_NEAR(area, 16, 1e-3);
}

/// Triangles that lie twice in one place must not make up for a hole beside them.
TEST(FlatRectangles, OverlappingTrianglesHideNoHole) {
  MeshModel wall = tiledWall(40, 20, 0.05f, [](int c, int) { return c % 4 == 1 || c % 4 == 2; });
  const size_t count = wall.triangles.size();
  // The same triangles once more, with vertices of their own.
  for (size_t t = 0; t < count; ++t) {
    std::array<uint32_t, 3> copy;
    for (int k = 0; k < 3; ++k) {
      copy[k] = static_cast<uint32_t>(wall.vertices.size());
      wall.vertices.push_back(wall.vertices[wall.triangles[t][k]]);
    }
    wall.triangles.push_back(copy);
  }
  // Every cell of a decimetre has one strip of 5 cm, twice, and one hole of 5 cm, so the areas add
  // up to a whole cell.
  for (const Rectangle& r : flatRectangles(wall, 0.5)) ADD_FAILURE() << areaOf(r);
}

TEST(FlatRectangles, ASlopedPlaneToo) {
  MeshModel wall = tiledWall(13, 7, 0.37f, [](int, int) { return false; });
  const Eigen::AngleAxisf turn(0.7f, Eigen::Vector3f(1, 2, 3).normalized());
  for (Eigen::Vector3f& v : wall.vertices) v = turn * v + Eigen::Vector3f(5, -3, 2);
  const std::vector<Rectangle> found = flatRectangles(wall, 0.5);
  double area = 0;
  for (const Rectangle& r : found) area += areaOf(r);
  EXPECT_GT(area, 0.9 * 13 * 7 * 0.37 * 0.37);
}

/// A wall of 4 x 3 m at x = 0, the eye at x = -1. By the theorem of intersecting lines, at x = 1
/// the wall hides y from -2 to 6 and z from -1.5 to 4.5 (eye at y = 2, z = 1.5).
TEST(LargeFaces, HideWhatLiesInTheirShadow) {
  const MeshModel wall = tiledWall(8, 6, 0.5f, [](int, int) { return false; });
  const LargeFaces faces(wall);
  const Eigen::Vector3f eye(-1, 2, 1.5f), half(0.2f, 0.3f, 0.1f);
  const auto hide = [&](float x, float y, float z) {
    return faces.hide(eye, {x, y, z}, half, 0.01f);
  };
  EXPECT_TRUE(hide(1, 2, 1.5f));
  EXPECT_TRUE(hide(1, 5, 1.5f));  // reaches from y = 4.7 to 5.3; at x = 0.8 the shadow ends at 5.6
  EXPECT_FALSE(hide(1, 5.5f, 1.5f));
  EXPECT_FALSE(hide(1, 6.5f, 1.5f));
  EXPECT_FALSE(hide(-0.5f, 2, 1.5f));   // before the wall
  EXPECT_FALSE(hide(0.205f, 2, 1.5f));  // closer behind it than the margin
  EXPECT_TRUE(hide(0.215f, 2, 1.5f));
  EXPECT_FALSE(faces.hide({0.9f, 2, 1.5f}, {1, 2, 1.5f}, half, 0.01f));  // the eye is in the box
}

TEST(LargeFaces, NeverHideABoxOfWhichAPointIsSeen) {
  const MeshModel rooms = test::furnishedRooms();
  const LargeFaces faces(rooms);
  RandomSource random(5);
  const auto blocked = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const Eigen::Vector3d way = to - from;
    return std::any_of(rooms.triangles.begin(), rooms.triangles.end(), [&](const auto& t) {
      const Eigen::Vector3d a = rooms.vertices[t[0]].template cast<double>();
      const Eigen::Vector3d u = rooms.vertices[t[1]].template cast<double>() - a;
      const Eigen::Vector3d v = rooms.vertices[t[2]].template cast<double>() - a;
      Eigen::Matrix3d m;
      m << u, v, -way;
      if (std::abs(m.determinant()) < 1e-12) return false;
      const Eigen::Vector3d x = m.inverse() * (from - a);
      return x[0] >= -1e-6 && x[1] >= -1e-6 && x[0] + x[1] <= 1 + 1e-6 && x[2] > 0 && x[2] < 1;
    });
  };
  int hidden = 0;
  for (int k = 0; k < 4000; ++k) {
    const Eigen::Vector3d eye(8 * random.uniform(), 5 * random.uniform(), 2.6 * random.uniform());
    const Eigen::Vector3d centre(8 * random.uniform(), 5 * random.uniform(),
                                 2.6 * random.uniform());
    const Eigen::Vector3d half =
        0.4 * Eigen::Vector3d(random.uniform(), random.uniform(), random.uniform());
    if (!faces.hide(eye.cast<float>(), centre.cast<float>(), half.cast<float>(), 0.01f)) continue;
    ++hidden;
    for (int i = 0; i < 20; ++i) {
      Eigen::Vector3d at = centre;
      for (int a = 0; a < 3; ++a) at[a] += half[a] * (2 * random.uniform() - 1);
      EXPECT_TRUE(blocked(eye, at)) << eye.transpose() << " to " << at.transpose();
    }
  }
  EXPECT_GT(hidden, 300);
}

TEST(LargeFaces, WithoutFacesNothingIsHidden) {
  EXPECT_FALSE(LargeFaces(MeshModel()).hide({0, 0, 0}, {5, 0, 0}, {1, 1, 1}, 0.01f));
}

}  // namespace
}  // namespace edge_mcl
