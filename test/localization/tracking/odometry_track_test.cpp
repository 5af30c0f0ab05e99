#include "edge_mcl/localization/tracking/odometry_track.h"

#include <gtest/gtest.h>

#include "edge_mcl/localization/filter/motion_noise.h"

namespace edge_mcl {
namespace {

Pose at(double x) { return Pose(Eigen::Translation3d(x, 0, 0)); }

TEST(OdometryTrack, AnIncrementNeedsTwoReadings) {
  OdometryTrack track{FilterParameters()};
  EXPECT_FALSE(track.incrementTo(at(1)));
  track.read(at(1));
  EXPECT_FALSE(track.incrementTo(std::nullopt));
  EXPECT_TRUE(track.incrementTo(at(1.5))->isApprox(at(0.5), 1e-12));
}

/// The reading at 2 m is missing, and the estimate moved by 1.1 m meanwhile. The next increment is
/// the rest of the way.
TEST(OdometryTrack, AMissingReadingLosesNoMotion) {
  OdometryTrack track{FilterParameters()};
  track.read(at(1));
  track.read(std::nullopt);
  track.carry(at(1.1), 0.1, 1);
  EXPECT_NEAR(track.incrementTo(at(3))->translation().x(), 0.9, 1e-12);
}

TEST(OdometryTrack, AReadingIsNotCarriedForLong) {
  OdometryTrack track{FilterParameters()};
  track.read(at(1));
  for (int i = 0; i < 11; ++i) track.carry(Pose::Identity(), 0.1, 1);
  EXPECT_FALSE(track.incrementTo(at(3)));
  track.read(at(3));
  EXPECT_TRUE(track.incrementTo(at(4)));
}

TEST(OdometryTrack, MotionOfSkippedImagesIsOneStep) {
  const FilterParameters params;
  OdometryTrack track(params);
  EXPECT_FALSE(track.isWaiting());
  for (int i = 0; i < 10; ++i) track.wait(at(0.1), 0.1);
  const OdometryStep step = track.waited();
  EXPECT_NEAR(step.pose.translation().x(), 1, 1e-9);
  EXPECT_NEAR(step.time, 1, 1e-9);
  EXPECT_LT((step.sigma - odometryNoise(params, at(1), 1)).norm(), 1e-9);
  track.endWaiting();
  EXPECT_FALSE(track.isWaiting());
}

/// Two minutes at rest count as the last step only.
TEST(OdometryTrack, RestAddsNoNoise) {
  const FilterParameters params;
  OdometryTrack track(params);
  for (int i = 0; i < 1200; ++i) track.wait(Pose::Identity(), 0.1);
  EXPECT_LT((track.waited().sigma - odometryNoise(params, Pose::Identity(), 0.1)).norm(), 1e-9);
}

/// A robot was carried: odometry before the new pose teaches nothing.
TEST(OdometryTrack, MotionBeforeANewPoseTeachesNothing) {
  OdometryTrack track{FilterParameters()};
  UpdateReport report;
  report.innovation_of_images = 1e-6 * Matrix6::Identity();
  track.update(report, true);
  track.wait(at(0.2), 0.1);
  track.endWaiting();
  track.wait(at(0.1), 0.1);
  track.interrupt();
  EXPECT_FALSE(track.isWaiting());
  report.innovation[0] = -0.1;
  track.update(report, true);
  EXPECT_EQ(track.calibration().scaleError(), 0);
  EXPECT_EQ(track.calibration().noiseFactor(), 1);
}

/// The images say that every step was 10 % longer than reported.
TEST(OdometryTrack, LearnsOnlyFromTrustedUpdates) {
  const auto scaleAfter = [](bool trusted) {
    OdometryTrack track{FilterParameters()};
    for (int i = 0; i < 100; ++i) {
      track.wait(at(0.1), 0.1);
      UpdateReport report;
      report.innovation[0] = 0.11 - track.waited().pose.translation().x();
      report.innovation_of_images = 1e-6 * Matrix6::Identity();
      track.endWaiting();
      track.update(report, trusted);
    }
    return track.calibration().scaleError();
  };
  EXPECT_NEAR(scaleAfter(true), 0.1, 0.02);
  EXPECT_EQ(scaleAfter(false), 0);
}

}  // namespace
}  // namespace edge_mcl
