#include "edge_mcl/core/mesh/closest_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <vector>

#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::anywhere;
using test::plainDistance;
using test::Random;
using test::uniform;

/// The truth is the closest point of a fine grid on the triangle.
TEST(ClosestPoint, NoPointOfTheTriangleIsCloser) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d a = anywhere(&random), b = anywhere(&random), c = anywhere(&random),
                          p = anywhere(&random, -2, 2);
    const Eigen::Vector3d closest = closestPointOnTriangle(p, a, b, c);
    constexpr int kGrid = 60;
    double least = INFINITY;
    for (int u = 0; u <= kGrid; ++u)
      for (int v = 0; u + v <= kGrid; ++v)
        least = std::min(least, (a + (b - a) * u / kGrid + (c - a) * v / kGrid - p).norm());
    // At least one point of the grid lies within a grid step of the closest point.
    const double step = ((b - a).norm() + (c - a).norm()) / kGrid;
    EXPECT_LE((closest - p).norm(), least + 1e-12);
    EXPECT_GE((closest - p).norm(), least - step);
  }
}

/// The triangle has the corners (0, 0), (4, 0) and (0, 3) in the plane z = 0. There is one point
/// for every region: the face, the three edges and the three corners.
TEST(ClosestPoint, EveryRegionOfATriangleHasItsClosedForm) {
  const Eigen::Vector3d a(0, 0, 0), b(4, 0, 0), c(0, 3, 0);
  const auto closest = [&](double x, double y, double z) {
    return closestPointOnTriangle({x, y, z}, a, b, c);
  };
  // The numbers are small and whole, so only the division rounds.
  constexpr double kRounding = 1e-12;
  EXPECT_LT((closest(1, 1, -5) - Eigen::Vector3d(1, 1, 0)).norm(), kRounding);
  EXPECT_LT((closest(2, -7, 1) - Eigen::Vector3d(2, 0, 0)).norm(), kRounding);
  EXPECT_LT((closest(-7, 2, 1) - Eigen::Vector3d(0, 2, 0)).norm(), kRounding);
  // The normal of the long side is (3, 4) / 5, and its middle is (2, 1.5).
  EXPECT_LT((closest(2 + 3, 1.5 + 4, 1) - Eigen::Vector3d(2, 1.5, 0)).norm(), kRounding);
  EXPECT_LT((closest(-1, -2, 3) - a).norm(), kRounding);
  EXPECT_LT((closest(9, -1, 3) - b).norm(), kRounding);
  EXPECT_LT((closest(-1, 9, 3) - c).norm(), kRounding);
}

/// The truth is the distance from every face, one by one.
TEST(ClosestFace, IsTheOneThatBruteForceFinds) {
  const MeshModel mesh = test::furnishedRooms();
  const ClosestFace faces(mesh);
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(uniform(&random, -1, 9), uniform(&random, -1, 6),
                            uniform(&random, -1, 3.6));
    const double truth = plainDistance(mesh, p);
    const ClosestFace::Hit hit = faces.find(p, 0.5);
    // The search runs in single precision. At its limit of 0.5 m it may find the face or not.
    if (std::abs(truth - 0.5) > 1e-5) {
      EXPECT_EQ(hit.found, truth < 0.5);
    }
    if (hit.found) {
      EXPECT_NEAR(hit.distance, truth, 1e-6);
    }
  }
}

TEST(ClosestFace, ItsPointLiesOnItsFaceAtItsDistance) {
  const MeshModel mesh = test::furnishedRooms();
  const ClosestFace faces(mesh);
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p(uniform(&random, 0, 8), uniform(&random, 0, 5),
                            uniform(&random, 0, 2.6));
    const ClosestFace::Hit hit = faces.find(p, 10);
    ASSERT_TRUE(hit.found);
    EXPECT_NEAR((hit.point - p).norm(), hit.distance, 1e-12);  // rounding of the difference
    const auto& t = mesh.triangles.at(hit.face);
    const Eigen::Vector3d on_face = closestPointOnTriangle(p, mesh.vertices[t[0]].cast<double>(),
                                                           mesh.vertices[t[1]].cast<double>(),
                                                           mesh.vertices[t[2]].cast<double>());
    EXPECT_LT((on_face - hit.point).norm(), 1e-12);
  }
}

MeshModel box() {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {1, 1, 1});
  return weldMesh(std::move(soup), 1e-6, "box");
}

TEST(ClosestFace, OutOfReachNothingIsFoundAndTheDistanceIsTheReach) {
  const MeshModel mesh = box();
  const ClosestFace faces(mesh);
  const ClosestFace::Hit near = faces.find({0.5, 0.5, 3}, 2.01),
                         far = faces.find({0.5, 0.5, 3}, 1.99);
  EXPECT_TRUE(near.found);
  EXPECT_DOUBLE_EQ(near.distance, 2);
  EXPECT_FALSE(far.found);
  EXPECT_EQ(far.distance, 1.99);
}

/// A corner of the box belongs to several faces. All of them have the same distance from a point
/// that lies beyond the corner. The face with the smallest number counts, so that the result does
/// not depend on the order of the search.
TEST(ClosestFace, OfFacesAtTheSameDistanceTheFirstOneCounts) {
  const MeshModel mesh = box();
  const ClosestFace faces(mesh);
  for (uint32_t corner = 0; corner < mesh.vertices.size(); ++corner) {
    const Eigen::Vector3d at = mesh.vertices[corner].cast<double>();
    uint32_t first = 0;
    while (std::count(mesh.triangles[first].begin(), mesh.triangles[first].end(), corner) == 0)
      ++first;
    const ClosestFace::Hit hit = faces.find(at + (at - Eigen::Vector3d::Constant(0.5)), 5);
    ASSERT_TRUE(hit.found);
    EXPECT_EQ(hit.face, first);
    EXPECT_EQ(hit.point, at);
  }
}

TEST(ClosestFace, IsTheSameFromSeveralThreads) {
  const MeshModel mesh = test::furnishedRooms();
  const ClosestFace faces(mesh);
  const auto distances = [&] {
    Random random(4);
    std::vector<double> result;
    result.reserve(300);
    for (int i = 0; i < 300; ++i) result.push_back(faces.find(anywhere(&random, 0, 3), 2).distance);
    return result;
  };
  const std::vector<double> alone = distances();
  std::vector<std::vector<double>> together(4);
  std::vector<std::thread> threads;
  threads.reserve(together.size());
  for (auto& result : together) threads.emplace_back([&] { result = distances(); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& result : together) EXPECT_EQ(result, alone);
}

}  // namespace
}  // namespace edge_mcl
