#include "edge_mcl/localization/filter/look_alikes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

constexpr double kRise = 0.18, kRun = 0.27;  // m, of a step

/// A flight of twelve steps along x, between two walls.
MeshModel stairs() {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {7, 2.6f, 4}, 0, true);          // the room
  test::addBox(&soup, {1.4f, 1.7f, 0}, {2.6f, 2.5f, 1.1f});       // a cupboard
  test::addBox(&soup, {3.4f, 2.2f, 1.5f}, {4.6f, 2.599f, 2.3f});  // another on the wall
  for (int i = 0; i < 12; ++i) {
    const auto x = static_cast<float>(2 + kRun * i);
    test::addBox(&soup, {x, 0, 0},
                 {x + static_cast<float>(kRun), 1.6f, static_cast<float>(kRise * (i + 1))});
  }
  return weldMesh(std::move(soup), 1e-6, "stairs");
}

/// A camera before the stairs that looks along them.
const Pose kPose = test::lookAlong({0.6, 0.8, 1.5}, {1, 0.05, -0.15});

CameraView viewOf(const LocalizationMap& map, const Pose& T_map_camera) {
  const CameraModel camera = test::pinhole(320, 240, 220);
  return {map.prepare(camera, test::render(map.mesh(), camera, T_map_camera), {}, "stairs"),
          Pose::Identity(), 1, nullptr};
}

bool hasShift(const std::vector<Eigen::Vector3d>& shifts, const Eigen::Vector3d& shift) {
  return std::any_of(shifts.begin(), shifts.end(),
                     [&](const Eigen::Vector3d& s) { return (s - shift).norm() < 0.03; });
}

TEST(LookAlikes, AStairRepeatsItselfAlongItsSlope) {
  const LocalizationMap map(stairs(), Parameters());
  const std::vector<Eigen::Vector3d> shifts = repeatsInView(map, viewOf(map, kPose), kPose);
  EXPECT_TRUE(hasShift(shifts, {kRun, 0, kRise}));
  EXPECT_TRUE(hasShift(shifts, {-kRun, 0, -kRise}));
}

TEST(LookAlikes, ThePoseOneStepOnFindsTheTrueOne) {
  const LocalizationMap map(stairs(), Parameters());
  Pose wrong = kPose;
  wrong.translation() += Eigen::Vector3d(kRun, 0, kRise);
  const auto found = bestLookAlike(map, {viewOf(map, kPose)}, wrong);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((found->pose.translation() - kPose.translation()).norm(), 0.03);
  EXPECT_GT(found->advantage, 8);
}

TEST(LookAlikes, FromTheTruePoseAllOthersAreWorse) {
  const LocalizationMap map(stairs(), Parameters());
  const auto found = bestLookAlike(map, {viewOf(map, kPose)}, kPose);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT(found->advantage, -8);
}

TEST(LookAlikes, WhereNothingRepeatsItselfThereIsNone) {
  MeshSoup soup;
  test::addBox(&soup, {2, 0, 0}, {3.5f, 2.5f, 1.9f});  // edges are 1.5 m apart or more
  const LocalizationMap map(weldMesh(std::move(soup), 1e-6, "box"), Parameters());
  EXPECT_FALSE(bestLookAlike(map, {viewOf(map, kPose)}, kPose).has_value());
}

TEST(LookAlikes, DepthAloneHasNone) {
  Parameters params;
  const LocalizationMap map(stairs(), params);
  EXPECT_FALSE(bestLookAlike(map, {}, kPose).has_value());
}

}  // namespace
}  // namespace edge_mcl
