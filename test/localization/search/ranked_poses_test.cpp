#include "edge_mcl/localization/search/ranked_poses.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "edge_mcl/core/base/angles.h"
#include "support/map_views.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

TEST(PlaceProbabilities, AddUpToOneAndFollowTheScores) {
  const std::vector<double> p = placeProbabilities({900, 850, 850, 300});
  ASSERT_EQ(p.size(), 5u);
  EXPECT_NEAR(std::accumulate(p.begin(), p.end(), 0.0), 1, 1e-12);
  EXPECT_GT(p[0], p[1]);
  EXPECT_EQ(p[1], p[2]);
  EXPECT_LT(p[3], 0.01);
  EXPECT_LT(p[4], 0.01);
}

TEST(PlaceProbabilities, WithoutEvidenceItIsSomewhereElse) {
  EXPECT_EQ(placeProbabilities({}), std::vector<double>{1});
  EXPECT_GT(placeProbabilities({-100}).back(), 0.9);
}

TEST(PlaceProbabilities, AreFiniteForAnyScore) {
  for (const double p : placeProbabilities({1e9, -1e9, 5e8})) {
    EXPECT_GE(p, 0);
    EXPECT_LE(p, 1);
  }
}

UpReading upOf(const Pose& pose) {
  return {pose.linear().transpose() * Eigen::Vector3d::UnitZ(), 1 * kDegree};
}

TEST(RankedPoses, TheFirstIsWhereTheImageWasTaken) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const Pose truth = test::roomView();
  PoseSearch search(map);
  RandomSource random(1);
  const RankedPoses ranked =
      rankPoses(&search, {test::viewInRoom(map)}, std::nullopt, std::nullopt, 5, &random);
  ASSERT_FALSE(ranked.poses.empty());
  EXPECT_LE(ranked.poses.size(), 5u);
  EXPECT_TRUE(isNear(ranked.poses.front().found.pose, truth, 0.05, 1 * kDegree));
  // The picture is small and shows few lines, so "somewhere else" keeps a share.
  EXPECT_GT(ranked.poses.front().probability, 0.6);
}

/// An empty room looks the same after half a turn.
TEST(RankedPoses, TwoPlacesThatLookAlikeAreEquallyLikely) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {5, 3, 2.5f}, 0, true);
  const MeshModel mesh = weldMesh(std::move(soup), 1e-6, "box");
  const Pose truth = [] {
    Pose pose = opticalOnBody();
    pose.prerotate(Eigen::AngleAxisd(20 * kDegree, Eigen::Vector3d::UnitZ()));
    pose.pretranslate(Eigen::Vector3d(1.5, 1.0, 1.2));
    return pose;
  }();
  Pose half_turn = Pose::Identity();
  half_turn.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  half_turn.translation() = Eigen::Vector3d(5, 3, 0);
  const LocalizationMap map(mesh, Parameters());
  CameraView view;
  view.image =
      map.prepare(test::roomCamera(), test::render(mesh, test::roomCamera(), truth, 1), {}, "box");
  PoseSearch search(map);
  RandomSource random(1);
  const RankedPoses ranked = rankPoses(&search, {view}, upOf(truth), std::nullopt, 5, &random);
  ASSERT_GE(ranked.poses.size(), 2u);
  const RankedPose &a = ranked.poses[0], &b = ranked.poses[1];
  EXPECT_NEAR(a.probability, b.probability, 0.05 * a.probability);
  if (ranked.poses.size() > 2) {
    EXPECT_GT(b.probability, 1.5 * ranked.poses[2].probability);
  }
  for (const Pose& pose : {truth, half_turn * truth})
    EXPECT_TRUE(isNear(a.found.pose, pose, 0.1, 2 * kDegree) ||
                isNear(b.found.pose, pose, 0.1, 2 * kDegree));
}

TEST(RankedPoses, OnlyTheRegionIsSearched) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  PoseSearch search(map);
  RandomSource random(1);
  const SearchRegion region{{6, 2.5, 1.3}, 1.5};
  const RankedPoses ranked =
      rankPoses(&search, {test::viewInRoom(map)}, upOf(test::roomView()), region, 5, &random);
  ASSERT_FALSE(ranked.poses.empty());
  // A refinement moves a pose by some decimetres.
  for (const RankedPose& pose : ranked.poses)
    EXPECT_LT((pose.found.pose.translation() - region.centre).norm(), region.radius + 0.8);
}

TEST(RankedPoses, ADarkImageIsSomewhereElse) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  PoseSearch search(map);
  RandomSource random(1);
  const RankedPoses ranked =
      rankPoses(&search, {test::darkView(map)}, upOf(test::roomView()), std::nullopt, 5, &random);
  EXPECT_GT(ranked.none, 0.8);
}

}  // namespace
}  // namespace edge_mcl
