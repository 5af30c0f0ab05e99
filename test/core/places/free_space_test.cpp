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
  // 3.6 x 2.6 x 2.1 m, counted on a grid of about 0.2 m.
  EXPECT_NEAR(space.volume(), 3.6 * 2.6 * 2.1, 0.15 * 3.6 * 2.6 * 2.1);
  for (const Eigen::Vector3d& place : space.places(0.4)) EXPECT_TRUE(space.contains(place));
  // A grid of 10 x 8 x 7 cells of at most 0.4 m; the outer ones lie at most 0.2 m from the walls.
  EXPECT_GE(space.places(0.4).size(), 8u * 6u * 5u);
}

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

TEST(FreeSpace, BetweenBuildingsIsNotInside) {
  MeshSoup soup;
  addBox(&soup, {0, 0, 0}, {4, 3, 2.5f});
  addBox(&soup, {10, 0, 0}, {14, 3, 2.5f});
  const MeshModel mesh = weld(soup);
  const FreeSpace space(mesh, {0.2, 0.7});
  EXPECT_TRUE(space.contains({12, 1.5, 1.2}));
  EXPECT_FALSE(space.contains({7, 1.5, 1.2}));
}

TEST(FreeSpace, AroundAnObjectEverythingInItsBoundsIsFree) {
  MeshSoup soup;  // a floor, and a box that stands on it
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
