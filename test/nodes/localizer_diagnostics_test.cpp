#include "edge_mcl/nodes/localizer/localizer_diagnostics.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

using Status = diagnostic_updater::DiagnosticStatusWrapper;

LocalizerFacts tracking() {
  LocalizerFacts facts;
  facts.silence = 0.1;
  facts.has_odometry = true;
  facts.images_received = 100;
  facts.result.state = LocalizerState::kTracking;
  facts.result.updated = true;
  return facts;
}

int levelOf(void (*diagnose)(const LocalizerFacts&, Status*), const LocalizerFacts& facts) {
  Status status;
  diagnose(facts, &status);
  EXPECT_FALSE(status.message.empty());
  return status.level;
}

TEST(LocalizerDiagnostics, ATrackedPoseIsWell) {
  for (const auto diagnose : {diagnosePose, diagnoseImages, diagnoseMotion})
    EXPECT_EQ(levelOf(diagnose, tracking()), Status::OK);
}

TEST(LocalizerDiagnostics, EachPartTellsItsOwnFault) {
  LocalizerFacts lost = tracking();
  lost.result.state = LocalizerState::kLost;
  EXPECT_EQ(levelOf(diagnosePose, lost), Status::ERROR);
  EXPECT_EQ(levelOf(diagnoseImages, lost), Status::OK);
  LocalizerFacts searching = tracking();
  searching.result.state = LocalizerState::kSearching;
  searching.result.search_keyframes = 3;
  EXPECT_EQ(levelOf(diagnosePose, searching), Status::WARN);
  Status progress;
  diagnosePose(searching, &progress);
  EXPECT_EQ(progress.message, "searching, 3 keyframes used");
  LocalizerFacts dark = tracking();
  dark.result.updated = false;
  dark.result.problem = "dark";
  EXPECT_EQ(levelOf(diagnoseImages, dark), Status::WARN);
  EXPECT_EQ(levelOf(diagnoseMotion, dark), Status::OK);
  LocalizerFacts slow = tracking();
  slow.images_dropped = 51;
  EXPECT_EQ(levelOf(diagnoseImages, slow), Status::WARN);
  EXPECT_EQ(levelOf(diagnosePose, slow), Status::OK);
  LocalizerFacts blind = tracking();
  blind.has_odometry = false;
  EXPECT_EQ(levelOf(diagnoseMotion, blind), Status::WARN);
  EXPECT_EQ(levelOf(diagnosePose, blind), Status::OK);
  blind.wants_odometry = false;
  EXPECT_EQ(levelOf(diagnoseMotion, blind), Status::OK);
}

/// An image that is skipped because the robot rests has no problem.
TEST(LocalizerDiagnostics, RestIsNoFault) {
  LocalizerFacts rest = tracking();
  rest.result.updated = false;
  EXPECT_EQ(levelOf(diagnoseImages, rest), Status::OK);
}

TEST(LocalizerDiagnostics, WithoutImagesEveryPartWarns) {
  for (const double silence : {-1.0, 2.5}) {
    LocalizerFacts silent = tracking();
    silent.silence = silence;
    for (const auto diagnose : {diagnosePose, diagnoseImages, diagnoseMotion})
      EXPECT_EQ(levelOf(diagnose, silent), Status::WARN);
  }
}

}  // namespace
}  // namespace edge_mcl
