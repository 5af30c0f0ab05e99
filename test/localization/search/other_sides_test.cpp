#include "edge_mcl/localization/search/other_sides.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

using Eigen::Vector3d;

/// A cupboard of 0.8 x 0.4 x 1.8 m on a floor whose middle is elsewhere.
MeshModel cupboard() {
  MeshSoup soup;
  test::addBox(&soup, {1, 2, 0}, {1.8f, 2.4f, 1.8f});
  test::addBox(&soup, {-10, -10, -0.1f}, {5, 5, -0.001f});
  return weldMesh(std::move(soup), 1e-6, "cupboard");
}

std::vector<Vector3d> cornersSeenFrom(const Pose& T_map_camera) {
  std::vector<Vector3d> corners;
  for (const double x : {1.0, 1.8})
    for (const double y : {2.0, 2.4})
      for (const double z : {0.0, 1.8})
        corners.push_back(T_map_camera.inverse() * Vector3d(x, y, z));
  return corners;
}

/// From the side opposite, each corner of the cupboard lies where another one lay before.
TEST(OtherSides, ThePoseBehindACupboardSeesItTheSameWay) {
  const LocalizationMap map(cupboard(), {});
  const Pose pose = test::lookAlong({0.3, -0.5, 1.2}, {0.4, 1, -0.1});
  const std::vector<Vector3d> seen = cornersSeenFrom(pose);
  const auto looksAlike = [&](const Pose& other) {
    const std::vector<Vector3d> there = cornersSeenFrom(other);
    return std::all_of(seen.begin(), seen.end(), [&](const Vector3d& corner) {
      return std::any_of(there.begin(), there.end(), [&](const Vector3d& c) {
        return (c - corner).norm() < 1e-5;  // the mesh is in single precision
      });
    });
  };
  const std::vector<Pose> others = OtherSides(map).of(pose);
  EXPECT_EQ(std::count_if(others.begin(), others.end(), looksAlike), 1);
  for (const Pose& other : others) {
    EXPECT_NEAR(other.translation().z(), 1.2, 1e-9);
    EXPECT_GT((other.translation() - pose.translation()).norm(), 1);
  }
}

TEST(OtherSides, ABuildingHasNone) {
  const LocalizationMap map(test::furnishedRooms(), {});
  EXPECT_TRUE(OtherSides(map).of(test::lookAlong({2, 2, 1}, {1, 0, 0})).empty());
}

/// A map of lines has no shapes. Its middle is that of its lines.
TEST(OtherSides, LinesAloneHaveAMiddle) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 1}};
  soup.lines = {{0, 1}, {1, 2}, {2, 3}};
  const LocalizationMap map(weldMesh(std::move(soup), 1e-6, "lines"), {});
  const std::vector<Pose> others = OtherSides(map).of(test::lookAlong({1, -2, 0.5}, {0, 1, 0}));
  ASSERT_EQ(others.size(), 3u);
  EXPECT_LT((others[1].translation() - Vector3d(1, 3, 0.5)).norm(), 1e-6);
}

}  // namespace
}  // namespace edge_mcl
