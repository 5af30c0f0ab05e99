// Compares the inputs of MRPT's built-in filters with closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/comparison/mrpt_filter_2d.h"
#include "edge_mcl/comparison/surface_points.h"
#include "edge_mcl/core/base/random_source.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

MeshModel box() {
  MeshSoup soup;
  test::addBox(&soup, {-2, -3, 0}, {2, 3, 2.5F}, 0, true);
  return weldMesh(std::move(soup), 1e-6, "box");
}

/// The truth is the six planes of a box.
TEST(SurfacePoints, LieOnTheSurfaceWithoutGaps) {
  constexpr double kSpacing = 0.1;
  const std::vector<Eigen::Vector3f> points = surfacePoints(box(), kSpacing);
  RandomSource random(3);
  const auto isOn = [](float v, float side) { return std::abs(v - side) < 1e-5F; };
  for (const Eigen::Vector3f& p : points) {
    EXPECT_TRUE(isOn(std::abs(p.x()), 2) || isOn(std::abs(p.y()), 3) || isOn(p.z(), 0) ||
                isOn(p.z(), 2.5F));
    EXPECT_TRUE((p.array() > Eigen::Array3f(-2.001F, -3.001F, -0.001F)).all() &&
                (p.array() < Eigen::Array3f(2.001F, 3.001F, 2.501F)).all());
  }
  // The places lie on a wall and on the floor, some of them near corners of triangles.
  for (int i = 0; i < 200; ++i) {
    const auto u = static_cast<float>(random.uniform()), v = static_cast<float>(random.uniform());
    const Eigen::Vector3f place = i % 2 == 0 ? Eigen::Vector3f(2, 6 * u - 3, 2.5F * v)
                                             : Eigen::Vector3f(4 * u - 2, 6 * v - 3, 0);
    float nearest = 1e9F;
    for (const Eigen::Vector3f& p : points) nearest = std::min(nearest, (p - place).norm());
    EXPECT_LT(nearest, kSpacing) << place.transpose();
  }
}

/// The outline of the box is a rectangle of 4 x 6 m, 20 m long.
TEST(Section, OfABoxIsItsOutline) {
  double length = 0;
  for (const auto& [a, b] : sectionOf(box(), 1.2)) {
    length += (b - a).norm();
    for (const Eigen::Vector2f& p : {a, b})
      EXPECT_TRUE(std::abs(std::abs(p.x()) - 2) < 1e-5F || std::abs(std::abs(p.y()) - 3) < 1e-5F);
  }
  EXPECT_NEAR(length, 20, 1e-4);
  EXPECT_TRUE(sectionOf(box(), 2.6).empty());
}

/// Points of a wall across the line of sight, in the axes of a camera that looks down. @param
/// distance of the wall, m
DepthPoints wall(double distance, const Pose& level_camera) {
  DepthPoints points;
  for (double y = -2.5; y <= 2.5; y += 0.01)
    for (double z = 0.8; z <= 1.8; z += 0.05) {
      const Eigen::Vector3d p = level_camera.inverse() * Eigen::Vector3d(distance, y, z);
      points.x.push_back(static_cast<float>(p.x()));
      points.y.push_back(static_cast<float>(p.y()));
      points.z.push_back(static_cast<float>(p.z()));
    }
  points.count = points.x.size();
  return points;
}

/// The true range of a wall at 2 m is 2 / cos(bearing).
TEST(Scan, OfAWallIsAsLongAsTheWayToIt) {
  Pose camera = Pose::Identity();
  camera.translation().z() = 1.3;
  camera.linear() = rotationFromAngles(0.05, 0.2, 0) * opticalOnBody().linear();
  const FloorPlanParameters plan;
  const auto scan = scanOf(wall(2, camera), camera, 1.3, plan);
  ASSERT_TRUE(scan);
  const auto count = static_cast<double>(scan->getScanSize());
  int hits = 0;
  for (size_t i = 0; i < scan->getScanSize(); ++i) {
    if (!scan->getScanRangeValidity(i)) continue;
    ++hits;
    const double bearing = scan->aperture * (static_cast<double>(i) / (count - 1) - 0.5);
    // A ray covers half a degree to either side. At 51 degrees this is 3.4 cm of range.
    EXPECT_NEAR(scan->getScanRange(i), 2 / std::cos(bearing), 0.035);
  }
  // The wall reaches 2.5 m to either side at 2 m distance, which is 51.3 degrees.
  EXPECT_NEAR(hits, 103, 2);
  EXPECT_FALSE(scanOf(wall(2, camera), camera, 3, plan)) << "no points at that height";
}

TEST(FloorPlan, IsOccupiedAlongTheWalls) {
  const auto grid = floorPlanOf(box(), 1.2, {});
  EXPECT_LT(grid->getPos(2.0F, 0.5F), 0.1F);
  EXPECT_LT(grid->getPos(-0.7F, 3.0F), 0.1F);
  EXPECT_GT(grid->getPos(0.3F, 0.4F), 0.9F);
}

}  // namespace
}  // namespace edge_mcl
