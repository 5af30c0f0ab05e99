#include "edge_mcl/localization/filter/look_alikes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/se3.h"
#include "support/stairs.h"

namespace edge_mcl {
namespace {

const Pose kPose = test::beforeStairs();

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
  const LocalizationMap map(test::stairs(), Parameters());
  const std::vector<Eigen::Vector3d> shifts = repeatsInView(map, viewOf(map, kPose), kPose);
  EXPECT_TRUE(hasShift(shifts, test::oneStep()));
  EXPECT_TRUE(hasShift(shifts, -test::oneStep()));
}

TEST(LookAlikes, ThePoseOneStepOnFindsTheTrueOne) {
  const LocalizationMap map(test::stairs(), Parameters());
  Pose wrong = kPose;
  wrong.translation() += test::oneStep();
  const auto found = bestLookAlike(map, {viewOf(map, kPose)}, wrong);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((found->pose.translation() - kPose.translation()).norm(), 0.03);
  EXPECT_GT(found->advantage, 8);
}

/// Such a pose is one that the search may find. It is no repeat of this one.
TEST(LookAlikes, APoseThatIsTurnedIsNone) {
  const LocalizationMap map(test::stairs(), Parameters());
  Pose turned = kPose;
  turned.linear() = kPose.linear() * Eigen::AngleAxisd(6 * kDegree, Eigen::Vector3d::UnitY());
  Pose wrong = kPose;
  wrong.translation() += test::oneStep();
  const auto found = bestLookAlike(map, {viewOf(map, turned)}, wrong);
  if (found) {
    EXPECT_LT(rotationAngle(found->pose, wrong), 3 * kDegree);
  }
}

TEST(LookAlikes, FromTheTruePoseAllOthersAreWorse) {
  const LocalizationMap map(test::stairs(), Parameters());
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
  const LocalizationMap map(test::stairs(), Parameters());
  const CameraView depth{nullptr, Pose::Identity(), 1, std::make_shared<DepthPoints>()};
  EXPECT_FALSE(bestLookAlike(map, {depth}, kPose).has_value());
}

}  // namespace
}  // namespace edge_mcl
