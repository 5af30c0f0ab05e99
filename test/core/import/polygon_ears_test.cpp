#include "edge_mcl/core/import/polygon_ears.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> flat(const std::vector<std::pair<double, double>>& corners) {
  std::vector<Vector3d> polygon;
  polygon.reserve(corners.size());
  for (const auto& [x, y] : corners) polygon.emplace_back(x, y, 0);
  return polygon;
}

/// Signed area of a polygon in the plane z = 0, by the shoelace formula.
double areaOf(const std::vector<Vector3d>& p) {
  double twice = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const Vector3d &a = p[i], &b = p[(i + 1) % p.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return twice / 2;
}

const std::vector<std::pair<double, double>> kT = {{0, 0}, {6, 0}, {6, 2}, {4, 2},
                                                   {4, 5}, {2, 5}, {2, 2}, {0, 2}};

/// The areas of the triangles must add up to the area of the polygon (shoelace formula). No
/// triangle may be flat or turned over.
TEST(PolygonEars, CoverThePolygonWithoutFlatTriangles) {
  std::vector<std::vector<std::pair<double, double>>> rooms = {
      kT,
      // Other walls begin on the sides of this room, so it has corners of 180 degrees.
      {{0, 0}, {1, 0}, {2, 0}, {5, 0}, {5, 2}, {5, 4}, {3, 4}, {0, 4}, {0, 1}},
      // This room has pilasters. Corners of different pilasters lie on one line.
      {{0, 0},
       {8, 0},
       {8, 4},
       {7, 4},
       {7, 3.7},
       {6, 3.7},
       {6, 4},
       {4, 4},
       {4, 3.7},
       {3, 3.7},
       {3, 4},
       {0, 4}}};
  for (auto& room : rooms)
    for (const bool reversed : {false, true}) {
      std::vector<Vector3d> polygon = flat(room);
      if (reversed) std::reverse(polygon.begin(), polygon.end());
      EXPECT_FALSE(isStrictlyConvex(polygon));
      // The polygon is turned and moved in space.
      const Eigen::AngleAxisd turn(0.7, Vector3d(1, 2, -1).normalized());
      std::vector<Vector3d> placed;
      placed.reserve(polygon.size());
      for (const Vector3d& p : polygon) placed.push_back(turn * p + Vector3d(3, -2, 1));
      const auto triangles = cutEars(placed);
      ASSERT_EQ(triangles.size(), polygon.size() - 2);
      double sum = 0;
      for (const auto& [a, b, c] : triangles) {
        const double area = areaOf({polygon[a], polygon[b], polygon[c]});
        EXPECT_GT(reversed ? -area : area, 1e-3);
        sum += area;
      }
      EXPECT_NEAR(sum, areaOf(polygon), 1e-9);
    }
}

/// A polygon that crosses itself, is flat or is bent gives no triangles.
TEST(PolygonEars, RegularPolygonsAreConvexAndCrossedOnesCannotBeCut) {
  std::vector<std::pair<double, double>> regular;
  regular.reserve(12);
  for (int i = 0; i < 12; ++i) regular.emplace_back(std::cos(i * M_PI / 6), std::sin(i * M_PI / 6));
  EXPECT_TRUE(isStrictlyConvex(flat(regular)));
  EXPECT_TRUE(cutEars(flat({{0, 0}, {2, 2}, {2, 0}, {0, 2}})).empty());
  EXPECT_TRUE(cutEars(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}})).empty());
  std::vector<Vector3d> bent = flat(kT);
  bent[4].z() = 1;
  EXPECT_TRUE(cutEars(bent).empty());
}

TEST(PolygonEars, ACornerThatComesTwiceIsOne) {
  auto corners = kT;
  corners.insert(corners.begin() + 3, corners[3]);
  corners.push_back(corners[0]);
  EXPECT_EQ(cutEars(flat(corners)).size(), kT.size() - 2);
}

/// When a mesh claims to have polygons and has none, assimp ends the process.
TEST(PolygonEars, AFloorAloneIsRead) {
  for (const char* more : {"", "f 1 2 3\n", "f 1 2 3 6\n", "l 1 4\n"}) {
    const std::string file = testing::TempDir() + "l_floor.obj";
    std::ofstream(file) << "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 2 2 0\nv 2 5 0\nv 0 5 0\n"
                        << "f 1 2 3 4 5 6\n"
                        << more;
    EXPECT_GE(loadMesh(file, {}).triangles.size(), 4u) << more;
  }
}

/// Floor and ceiling are one polygon each, as many programs write them. In a closed room every side
/// of a triangle belongs to two triangles. The area is known: floor and ceiling have 18 m^2 each,
/// the walls are 22 m long and 2.5 m high.
TEST(PolygonEars, ARoomOfPolygonsIsClosed) {
  const std::string file = testing::TempDir() + "t_room.obj";
  {
    std::ofstream out(file);
    for (const double z : {0.0, 2.5})
      for (const auto& [x, y] : kT) out << "v " << x << ' ' << y << ' ' << z << '\n';
    out << "f 8 7 6 5 4 3 2 1\nf 9 10 11 12 13 14 15 16\n";
    for (int i = 0; i < 8; ++i) {
      const int next = (i + 1) % 8;
      out << "f " << i + 1 << ' ' << next + 1 << ' ' << next + 9 << ' ' << i + 9 << '\n';
    }
  }
  const MeshModel mesh = loadMesh(file, {});
  EXPECT_EQ(mesh.report.degenerate_triangles, 0u);
  EXPECT_EQ(mesh.triangles.size(), 2u * 6 + 8 * 2);
  std::map<std::pair<uint32_t, uint32_t>, int> sides;
  double area = 0;
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
    const Eigen::Vector3f a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
    area += static_cast<double>((b - a).cross(c - a).norm()) / 2;
  }
  for (const auto& [side, count] : sides) EXPECT_EQ(count, 2);
  EXPECT_NEAR(area, 2 * 18 + 22 * 2.5, 1e-4);
}

}  // namespace
}  // namespace edge_mcl
