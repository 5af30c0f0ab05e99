#include "edge_mcl/core/places/free_space.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::addBox;

MeshModel weld(MeshSoup soup) {
  soup.triangle_material.assign(soup.triangles.size(), 0);
  return weldMesh(std::move(soup), 1e-6, "test");
}

/// The truth is a room of 4 x 3 x 2.5 m. With a clearance of 0.2 m its free space is 3.6 x 2.6
/// x 2.1 m.
TEST(FreeSpace, TheInsideOfARoomWithoutTheClearance) {
  MeshSoup soup;
  addBox(&soup, {0, 0, 0}, {4, 3, 2.5f});
  const MeshModel mesh = weld(soup);
  const FreeSpace space(mesh, {0.2, 0.7});
  EXPECT_TRUE(space.isEnclosed());
  EXPECT_TRUE(space.contains({2, 1.5, 1.2}));
  EXPECT_TRUE(space.contains({0.25, 0.25, 0.25}));
  EXPECT_FALSE(space.contains({0.15, 1.5, 1.2}));
  EXPECT_FALSE(space.contains({2, 1.5, 2.4}));
  EXPECT_FALSE(space.contains({5, 1.5, 1.2}));
  // The volume is counted on a grid of about 0.2 m.
  EXPECT_NEAR(space.volume(), 3.6 * 2.6 * 2.1, 0.15 * 3.6 * 2.6 * 2.1);
  for (const Eigen::Vector3d& place : space.places(0.4)) EXPECT_TRUE(space.contains(place));
  // The places lie on a grid of 10 x 8 x 7 cells of at most 0.4 m. The centres of the outer cells
  // lie at most 0.2 m from the walls, so they may be left out.
  EXPECT_GE(space.places(0.4).size(), 8u * 6u * 5u);
}

/// admits() needs half the clearance of 0.2 m, contains() all of it.
TEST(FreeSpace, AnEstimatedPoseMayBeHalfAsFarFromWallsButNotInThem) {
  MeshSoup soup;
  addBox(&soup, {0, 0, 0}, {4, 3, 2.5f});
  const MeshModel mesh = weld(soup);
  const FreeSpace space(mesh, {0.2, 0.7});
  EXPECT_TRUE(space.admits({0.15, 1.5, 1.2}));
  EXPECT_FALSE(space.contains({0.15, 1.5, 1.2}));
  EXPECT_FALSE(space.admits({0.05, 1.5, 1.2}));
  EXPECT_FALSE(space.admits({4, 1.5, 1.2}));
  EXPECT_FALSE(space.admits({5, 1.5, 1.2}));
}

/// The model has two buildings, 6 m apart.
TEST(FreeSpace, BetweenBuildingsIsNotInside) {
  MeshSoup soup;
  addBox(&soup, {0, 0, 0}, {4, 3, 2.5f});
  addBox(&soup, {10, 0, 0}, {14, 3, 2.5f});
  const MeshModel mesh = weld(soup);
  const FreeSpace space(mesh, {0.2, 0.7});
  EXPECT_TRUE(space.contains({12, 1.5, 1.2}));
  EXPECT_FALSE(space.contains({7, 1.5, 1.2}));
}

/// A floor with a box surrounds no space. Then all space in the bounds is free, as far as the
/// clearance allows.
TEST(FreeSpace, AroundAnObjectEverythingInItsBoundsIsFree) {
  MeshSoup soup;  // a floor, and a box on it
  soup.vertices = {{-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  addBox(&soup, {-0.2f, -0.2f, 0}, {0.2f, 0.2f, 2});
  const MeshModel mesh = weld(soup);
  const FreeSpace space(mesh, {0.3, 0.7});
  EXPECT_FALSE(space.isEnclosed());
  EXPECT_TRUE(space.contains({2, 2, 1}));
  EXPECT_FALSE(space.contains({0.4, 0, 1}));
  EXPECT_TRUE(space.admits({4, 0, 1}));
  EXPECT_FALSE(space.contains({4, 0, 1}));
}

TEST(FreeSpace, LinesAloneBlockNothing) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {5, 0, 0}, {5, 4, 3}};
  soup.lines = {{0, 1}, {1, 2}};
  const MeshModel mesh = weldMesh(std::move(soup), 1e-6, "test");
  const FreeSpace space(mesh, {0.2, 0.7});
  EXPECT_FALSE(space.isEnclosed());
  EXPECT_TRUE(space.contains({2, 2, 1}));
  EXPECT_FALSE(space.contains({2, 2, 4}));
}

}  // namespace
}  // namespace edge_mcl
