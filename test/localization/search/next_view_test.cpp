// Tests the view that tells two places apart.
#include <gtest/gtest.h>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/localization/search/global_localizer.h"
#include "edge_mcl/localization/search/next_view.h"
#include "support/room_view.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

constexpr float kLength = 8, kWidth = 5, kHeight = 3;

/// A hall that looks the same after half a turn but for a cupboard at one end.
/// @param with_cupboard false: it looks the same everywhere.
MeshModel hall(bool with_cupboard) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {kLength, kWidth, kHeight}, 0, true);
  // Shelves on both long walls, turned into each other by half a turn.
  test::addBox(&soup, {3, 0.05f, 0}, {4.5f, 0.5f, 1.6f});
  test::addBox(&soup, {3.5f, 4.5f, 0}, {5, 4.95f, 1.6f});
  if (with_cupboard) test::addBox(&soup, {7.3f, 1.5f, 0}, {7.95f, 3.2f, 2.1f});
  return weldMesh(std::move(soup), 1e-6, "hall");
}

Pose halfTurn() {
  Pose turn = Pose::Identity();
  turn.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  turn.translation() = Eigen::Vector3d(kLength, kWidth, 0);
  return turn;
}

/// T_map_camera: in the middle of the hall, looking at the shelf on one side.
Pose besideTheShelf() { return test::lookAlong({3.6, 3.2, 1.4}, {0.15, -1, -0.1}); }

CameraView viewAt(const LocalizationMap& map, const MeshModel& mesh, const Pose& pose) {
  CameraView view;
  view.image =
      map.prepare(test::roomCamera(), test::render(mesh, test::roomCamera(), pose, 1), {}, "hall");
  return view;
}

/// Whether a camera sees the middle of the cupboard. The hall hides nothing of it.
bool seesCupboard(const Pose& T_map_camera) {
  Eigen::Vector2d pixel;
  const Eigen::Vector3d cupboard(7.3, 2.35, 1.05);
  return test::roomCamera().project(T_map_camera.inverse() * cupboard, &pixel) &&
         test::roomCamera().contains(pixel);
}

TEST(NextView, ShowsWhatOnlyOnePlaceHas) {
  const MeshModel mesh = hall(true);
  const LocalizationMap map(mesh, Parameters());
  const Pose first = besideTheShelf(), second = halfTurn() * first;
  const auto next = nextView(map, {viewAt(map, mesh, first)}, first, second);
  ASSERT_TRUE(next);
  EXPECT_NE(seesCupboard(next->first), seesCupboard(next->second));
  EXPECT_GT(next->difference, 0.1);
  EXPECT_LE(next->difference, 1);
  // The same motion leads there from both places.
  EXPECT_TRUE((first.inverse() * next->first).isApprox(second.inverse() * next->second, 1e-9));
}

TEST(NextView, IsNoneWhereEverythingLooksTheSame) {
  const MeshModel mesh = hall(false);
  const LocalizationMap map(mesh, Parameters());
  const Pose first = besideTheShelf();
  EXPECT_FALSE(nextView(map, {viewAt(map, mesh, first)}, first, halfTurn() * first));
}

TEST(NextView, IsNoneWithoutAnImage) {
  const LocalizationMap map(hall(true), Parameters());
  EXPECT_FALSE(nextView(map, {CameraView()}, besideTheShelf(), halfTurn() * besideTheShelf()));
}

/// The camera looks along -y and is told to go where +x was: to its left.
TEST(NextView, TheStepIsAsThePilotSeesIt) {
  const Pose now = test::lookAlong({3, 3, 1}, {0, -1, -0.3});
  NextView view;
  view.first = test::lookAlong({5, 2.5, 1.25}, {1, 0, -0.3});
  const NextView::Step step = view.stepFrom(now, Pose::Identity());
  EXPECT_TRUE(step.shift.isApprox(Eigen::Vector3d(0.5, 2, 0.25), 1e-9)) << step.shift.transpose();
  EXPECT_NEAR(step.turn, M_PI / 2, 1e-9);
}

/// A robot that stands between two shelves and looks at one of them may be in two places. It flies
/// where the search sends it, whichever place is right, and is then known to be in the right one.
TEST(NextView, FlyingThereTellsThePlacesApart) {
  const MeshModel mesh = hall(true);
  const LocalizationMap map(mesh, quickSearch());
  for (const Pose& start : {besideTheShelf(), Pose(halfTurn() * besideTheShelf())}) {
    GlobalLocalizer search(map, 1);
    search.begin();
    Pose truth = start;
    RandomSource random(3);
    const auto look = [&] {
      UpReading up;
      up.sigma = kDegree;
      up.up_base = truth.linear().transpose() * Eigen::Vector3d::UnitZ();
      return search.process({viewAt(map, mesh, truth)}, up);
    };
    SearchReport report = look();
    ASSERT_GE(report.clusters.size(), 2u);
    EXPECT_NEAR(report.clusters[0].probability, report.clusters[1].probability, 0.1);
    EXPECT_FALSE(report.convincing);
    ASSERT_TRUE(report.next_view);
    const Pose motion = report.clusters[0].pose.inverse() * report.next_view->first;
    const auto fly = [&](const Pose& step) {
      truth = normalized(truth * step);
      search.move(BaseMotion::of(map.params().filter, step, 0.5));
      report = look();
    };
    // The robot shifts and turns by an eighth of the motion at a time.
    constexpr int kSteps = 8;
    const Twist whole = logSe3(motion);
    for (int i = 0; i < kSteps; ++i) fly(expSe3(whole / kSteps));
    EXPECT_TRUE(isNear(report.estimate.mean, truth, 0.1, 3 * kDegree));
    EXPECT_GT(report.clusters[0].probability, 2 * report.clusters[1].probability);
  }
}

}  // namespace
}  // namespace edge_mcl
