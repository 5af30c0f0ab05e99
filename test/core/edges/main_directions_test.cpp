#include "edge_mcl/core/edges/main_directions.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

EdgeModel edgesOf(MeshSoup soup, const Eigen::Matrix3f& turn) {
  for (Eigen::Vector3f& v : soup.vertices) v = turn * v;
  MeshModel mesh = weldMesh(std::move(soup), 1e-6, "test");
  return buildEdgeModel(&mesh, {});
}

/// The truth is the axes of the turned box, in the order of its sides: 7, 4 and 2.5 m.
TEST(MainDirections, OfATurnedBoxAreItsSidesTheLongestFirst) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {4, 7, 2.5f});
  const Eigen::Matrix3f turn = (Eigen::AngleAxisf(0.4f, Eigen::Vector3f::UnitZ()) *
                                Eigen::AngleAxisf(0.2f, Eigen::Vector3f::UnitX()))
                                   .toRotationMatrix();
  const std::vector<Eigen::Vector3d> found = mainDirections(edgesOf(soup, turn));
  ASSERT_EQ(found.size(), 3u);
  for (const auto& [k, axis] : {std::pair(0, 1), std::pair(1, 0), std::pair(2, 2)})
    EXPECT_NEAR(std::abs(found[static_cast<size_t>(k)].dot(turn.col(axis).cast<double>())), 1, 1e-5)
        << k;
}

TEST(MainDirections, OfOneLineIsThatLine) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {3, 4, 0}};
  soup.lines = {{0, 1}};
  const std::vector<Eigen::Vector3d> found =
      mainDirections(edgesOf(soup, Eigen::Matrix3f::Identity()));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(std::abs(found.front().dot(Eigen::Vector3d(0.6, 0.8, 0))), 1, 1e-6);
}

TEST(MainDirections, LeaveOutWhatHardlyAnyLineFollows) {
  MeshSoup soup;  // two walls of a floor plan and a post of 0.3 m
  soup.vertices = {{0, 0, 0}, {10, 0, 0}, {10, 8, 0}, {0, 0, 0.3f}};
  soup.lines = {{0, 1}, {1, 2}, {0, 3}};
  EXPECT_EQ(mainDirections(edgesOf(soup, Eigen::Matrix3f::Identity())).size(), 2u);
}

TEST(MainDirections, OfNothingAreNone) { EXPECT_TRUE(mainDirections(EdgeModel()).empty()); }

}  // namespace
}  // namespace edge_mcl
