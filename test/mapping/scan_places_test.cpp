#include "edge_mcl/mapping/scan_places.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace edge_mcl {
namespace {

std::vector<Eigen::Vector3d> spreadPlaces(const Eigen::Vector3d& high) {
  std::vector<Eigen::Vector3d> places;
  forSpreadPlaces({0, 0, 0}, high, 0.5, [&](const Eigen::Vector3d& p) { places.push_back(p); });
  return places;
}

/// The grid of 10 x 6 x 2 corners, each once. The first ones are eight spacings apart.
TEST(SpreadPlaces, CoverABoxAndBeginFarApart) {
  const std::vector<Eigen::Vector3d> places = spreadPlaces({5, 3, 1});
  ASSERT_EQ(places.size(), 10u * 6 * 2);
  for (size_t i = 0; i < places.size(); ++i) {
    EXPECT_GT(places[i].minCoeff(), 0);
    EXPECT_LT((places[i] - Eigen::Vector3d(5, 3, 1)).maxCoeff(), 0);
    for (size_t j = 0; j < i; ++j) EXPECT_GT((places[i] - places[j]).norm(), 0.49);
  }
  EXPECT_LT((places[0] - Eigen::Vector3d(0.25, 0.25, 0.25)).norm(), 1e-12);
  EXPECT_LT((places[1] - Eigen::Vector3d(4.25, 0.25, 0.25)).norm(), 1e-12);
}

TEST(SpreadPlaces, ABoxOfLessThanHalfASpacingHasNone) {
  EXPECT_TRUE(spreadPlaces({0.1, 0.1, 0.1}).empty());
}

std::vector<SurfacePiece> wall(float x, float distance, float facing) {
  constexpr int kPieces = 10;
  std::vector<SurfacePiece> pieces;
  pieces.reserve(kPieces);
  for (int i = 0; i < kPieces; ++i)
    pieces.push_back({{x, static_cast<float>(i) + 0.5f, 0.5f}, {facing, 0, 0}, distance});
  return pieces;
}

TEST(SeenSurface, EnoughIsEnough) {
  SeenSurface seen(2, 6);
  EXPECT_TRUE(seen.add(wall(3.2f, 2, -1)));
  EXPECT_TRUE(seen.add(wall(3.2f, 5, -1)));
  EXPECT_FALSE(seen.add(wall(3.2f, 2, -1)));
  // The other side of a thin wall is another surface.
  EXPECT_TRUE(seen.add(wall(3.2f, 2, 1)));
}

TEST(SeenSurface, WhatIsFarIsNotSeen) {
  SeenSurface seen(1, 6);
  EXPECT_FALSE(seen.add(wall(3.2f, 7, -1)));
  EXPECT_TRUE(seen.add(wall(3.2f, 2, -1)));
}

}  // namespace
}  // namespace edge_mcl
