// Tests when a tracked pose is trusted. The test renders the images itself.
#include "edge_mcl/localization/tracking/live_localizer.h"

#include <gtest/gtest.h>

#include "support/scenes.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

const Pose kView = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});
const Pose kElsewhere = test::lookAlong({4.6, 2.4, 1.3}, {1, -0.3, -0.1});

class LiveLocalizerTest : public testing::Test {
 protected:
  const CameraModel camera_ = test::pinhole(320, 240, 220);
  const cv::Mat here_ = test::render(test::furnishedRooms(), camera_, kView, 1);
  const cv::Mat elsewhere_ = test::render(test::furnishedRooms(), camera_, kElsewhere, 1);

  /// Parameters without a search, so that the filter is tested alone.
  static Parameters alone() {
    Parameters params;
    params.filter.particles = 300;
    params.search.recover = false;
    params.depth.store_field = false;
    return params;
  }
  static PoseGaussian around(const Pose& mean, double position, double angle) {
    PoseGaussian pose;
    pose.mean = mean;
    pose.covariance.diagonal().head<3>().setConstant(position * position);
    pose.covariance.diagonal().tail<3>().setConstant(angle * angle);
    return pose;
  }
  LiveLocalizer begun(const Parameters& params) const {
    LiveLocalizer localizer(std::make_shared<LocalizationMap>(test::furnishedRooms(), params));
    localizer.setPose(around(kView, 0.02, 0.01));
    return localizer;
  }
  LiveInput input(double time, const cv::Mat& image,
                  const Pose& odometry = Pose::Identity()) const {
    LiveInput input;
    input.time = time;
    input.odometry = odometry;
    LiveInput::CameraImage view;
    view.camera = camera_;
    view.image = image;
    view.origin = "image";
    input.images = {view};
    return input;
  }
};

/// A pose of RViz takes its height and tilt from the pose before. A pose that no image has
/// confirmed, or that is lost, would give wrong ones.
TEST_F(LiveLocalizerTest, ThePoseBeforeIsOneThatWasTracked) {
  LiveLocalizer right = begun(alone()), wrong = begun(alone());
  wrong.setPose(around(kElsewhere, 0.02, 0.01));
  EXPECT_FALSE(right.trackedPose(5));
  for (int i = 0; i < 20; ++i) {
    right.process(input(0.1 * i, here_));
    wrong.process(input(0.1 * i, here_));
    EXPECT_FALSE(wrong.trackedPose(5)) << "image " << i;
  }
  ASSERT_TRUE(right.trackedPose(5));
  EXPECT_LT((right.trackedPose(5)->mean.translation() - kView.translation()).norm(), 0.05);
  for (int i = 0; i < 80; ++i) right.process(input(2 + 0.1 * i, elsewhere_));
  EXPECT_FALSE(right.trackedPose(5));
}

/// Only images after 0.2 m of motion are used. The images show another place, so the pose must
/// become lost.
TEST_F(LiveLocalizerTest, WhereFewImagesAreUsedAWrongPoseIsLostToo) {
  Parameters params = alone();
  params.tracking.update_min_d = 0.2;
  LiveLocalizer localizer = begun(params);
  EXPECT_EQ(localizer.process(input(0, here_)).state, LocalizerState::kTracking);
  bool lost = false;
  for (int i = 1; i <= 50; ++i) {  // five images are used per metre
    Pose odometry = Pose::Identity();
    odometry.translation().x() = 0.05 * (i % 40 < 20 ? i % 40 : 40 - i % 40);
    lost |= localizer.process(input(0.1 * i, elsewhere_, odometry)).state == LocalizerState::kLost;
  }
  EXPECT_TRUE(lost);
}

/// Without motion no further image is used, so a picture of another place cannot contradict the
/// pose.
TEST_F(LiveLocalizerTest, AtRestItStaysAsItIs) {
  Parameters params = alone();
  params.tracking.update_min_d = 0.2;
  LiveLocalizer localizer = begun(params);
  for (int i = 0; i < 50; ++i)  // images of another place are not used at rest
    EXPECT_EQ(localizer.process(input(0.1 * i, i == 0 ? here_ : elsewhere_)).state,
              LocalizerState::kTracking);
}

/// Rest adds no noise. After two minutes the first image that is used must find the pose where it
/// was, and not one of the lines beside it.
TEST_F(LiveLocalizerTest, RestDoesNotSpreadTheParticles) {
  Parameters params = alone();
  params.tracking.update_min_d = 0.2;
  LiveLocalizer localizer = begun(params);
  for (int i = 0; i < 1200; ++i) {
    const LiveResult result = localizer.process(input(0.1 * i, here_));
    ASSERT_EQ(result.state, LocalizerState::kTracking) << i;
    ASSERT_LT(std::sqrt(result.estimate.covariance.diagonal().head<3>().maxCoeff()), 0.05) << i;
  }
  LiveInput used = input(120, here_);
  used.force_update = true;
  const LiveResult result = localizer.process(used);
  EXPECT_TRUE(result.updated);
  EXPECT_LT((result.estimate.mean.translation() - kView.translation()).norm(), 0.03);
}

/// Between used images the pose follows odometry.
TEST_F(LiveLocalizerTest, WhileImagesAreSkippedThePoseMovesOn) {
  Parameters params = alone();
  params.tracking.update_min_d = 0.2;
  LiveLocalizer localizer = begun(params);
  const Pose before = localizer.process(input(0, here_)).estimate.mean;
  for (int i = 1; i <= 3; ++i) {
    Pose odometry = Pose::Identity();
    odometry.translation().x() = 0.05 * i;
    const LiveResult result = localizer.process(input(0.1 * i, elsewhere_, odometry));
    EXPECT_FALSE(result.updated);
    const Twist moved = logSe3(before.inverse() * result.estimate.mean);
    EXPECT_NEAR(moved[0], 0.05 * i, 1e-6);
  }
}

/// The image is dark, so only odometry moves the pose. One reading is missing: the next one
/// contains its motion.
TEST_F(LiveLocalizerTest, AMissingReadingOfOdometryLosesNoMotion) {
  LiveLocalizer localizer = begun(alone());
  const cv::Mat dark(here_.size(), here_.type(), cv::Scalar::all(0));
  const Pose start = localizer.process(input(0, here_)).estimate.mean;
  LiveResult result;
  for (int i = 1; i <= 4; ++i) {
    Pose odometry = Pose::Identity();
    odometry.translation().x() = 0.1 * i;
    LiveInput moment = input(0.1 * i, dark, odometry);
    if (i == 2) moment.odometry.reset();
    result = localizer.process(moment);
  }
  // The velocity before the gap moves the pose by a few millimetres.
  EXPECT_NEAR(logSe3(start.inverse() * result.estimate.mean)[0], 0.4, 0.02);
}

/// After the clock jumped back the pose is the given one, and odometry moves it from the next
/// moment on.
TEST_F(LiveLocalizerTest, AfterARestartOdometryGoesOn) {
  LiveLocalizer localizer = begun(alone());
  const cv::Mat dark(here_.size(), here_.type(), cv::Scalar::all(0));
  localizer.process(input(100, here_));
  const LiveResult restarted = localizer.process(input(1, dark));
  ASSERT_TRUE(restarted.restarted);
  Pose odometry = Pose::Identity();
  odometry.translation().x() = 0.1;
  const LiveResult next = localizer.process(input(1.1, dark, odometry));
  EXPECT_NEAR(logSe3(restarted.estimate.mean.inverse() * next.estimate.mean)[0], 0.1, 1e-6);
}

/// The probability says what the state says.
TEST_F(LiveLocalizerTest, TheProbabilityFollowsTheImages) {
  LiveLocalizer localizer = begun(alone());
  LiveResult result;
  for (int i = 0; i < 20; ++i) result = localizer.process(input(0.1 * i, here_));
  EXPECT_EQ(result.state, LocalizerState::kTracking);
  EXPECT_GT(result.probability, 0.9);
  for (int i = 20; i < 60; ++i) result = localizer.process(input(0.1 * i, elsewhere_));
  EXPECT_EQ(result.state, LocalizerState::kLost);
  EXPECT_LT(result.probability, 0.2);
}

TEST_F(LiveLocalizerTest, AfterAGapOneImageProvesNothing) {
  LiveLocalizer localizer = begun(alone());
  double time = 0;
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(localizer.process(input(time += 0.1, here_)).state, LocalizerState::kTracking);
  time += 10;
  EXPECT_EQ(localizer.process(input(time, here_)).state, LocalizerState::kDegraded);
  for (int i = 0; i < 30; ++i) localizer.process(input(time += 0.1, here_));
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

TEST_F(LiveLocalizerTest, ASlowCameraHasNoGaps) {
  LiveLocalizer localizer = begun(alone());
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(localizer.process(input(5.0 * i, here_)).state, LocalizerState::kTracking) << i;
}

/// The camera sends six images within 2 s, and then none for 4 s.
TEST_F(LiveLocalizerTest, NorHasOneThatSendsBursts) {
  LiveLocalizer localizer = begun(alone());
  double time = 0;
  int tracked = 0;
  for (int burst = 0; burst < 6; ++burst) {
    for (int i = 0; i < 6; ++i) {
      const LocalizerState state = localizer.process(input(time += 0.3, here_)).state;
      EXPECT_NE(state, LocalizerState::kLost);
      tracked += state == LocalizerState::kTracking ? 1 : 0;
    }
    time += 4;
  }
  EXPECT_GE(tracked, 31);  // of 36; only the first pause is taken for a gap
}

TEST_F(LiveLocalizerTest, AfterAGapImagesAreLookedAtAtRestToo) {
  Parameters params = alone();
  params.tracking.update_min_d = 0.05;
  LiveLocalizer localizer = begun(params);
  double time = 0;
  for (int i = 0; i < 20; ++i) {
    Pose odometry = Pose::Identity();
    odometry.translation().x() = i % 2 ? 0 : 0.002;
    localizer.process(input(time += 0.1, here_, odometry));
  }
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
  time += 10;  // the robot is carried elsewhere, and odometry does not notice it
  int tracked = 0;
  for (int i = 0; i < 40; ++i)
    tracked += localizer.process(input(time += 0.1, elsewhere_)).state == LocalizerState::kTracking;
  EXPECT_EQ(tracked, 0);
  EXPECT_EQ(localizer.state(), LocalizerState::kLost);
}

/// A doubtful image makes the pose degraded. Good images at rest must make it tracking again, and
/// the next doubtful image must not make it lost.
TEST_F(LiveLocalizerTest, RestCostsNothing) {
  Parameters params = alone();
  params.tracking.update_min_d = 0.05;
  LiveLocalizer localizer = begun(params);
  localizer.process(input(0, here_));
  LiveInput doubted = input(0.1, elsewhere_);
  doubted.force_update = true;
  EXPECT_EQ(localizer.process(doubted).state, LocalizerState::kDegraded);
  double time = 0.1;
  // The robot is at rest.
  for (int i = 0; i < 100; ++i) localizer.process(input(time += 0.1, here_));
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
  doubted.time = time + 0.1;
  EXPECT_EQ(localizer.process(doubted).state, LocalizerState::kDegraded);
}

TEST_F(LiveLocalizerTest, WithoutRefinementItTracks) {
  Parameters params = alone();
  params.refinement.enabled = false;
  LiveLocalizer localizer = begun(params);
  LiveResult result;
  for (int i = 0; i < 20; ++i) result = localizer.process(input(0.1 * i, here_));
  EXPECT_EQ(result.state, LocalizerState::kTracking);
  // At the true pose all samples match, except on lines seen end-on.
  EXPECT_GT(result.match_ratio, 0.6);
}

/// The image is black, and the depth image is exact.
TEST_F(LiveLocalizerTest, InTheDarkDepthIsProofEnough) {
  Parameters params = alone();
  params.likelihood.cues = Cues::kBoth;
  LiveLocalizer localizer(std::make_shared<LocalizationMap>(test::furnishedRooms(), params));
  localizer.setPose(around(kView, 0.35, 0.02));  // wide, so that the pose has to be proven
  LiveInput::Depth depth;
  depth.image.camera = camera_;
  depth.image.depth = test::renderDepth(test::furnishedRooms(), camera_, kView);
  depth.image.origin = "depth";
  const cv::Mat dark(240, 320, CV_8U, cv::Scalar(0));
  LiveResult result;
  for (int i = 0; i < 30; ++i) {
    LiveInput now = input(0.1 * i, dark);
    now.depths = {depth};
    result = localizer.process(now);
  }
  EXPECT_GT(result.report.depth_agreement, 0.9);
  EXPECT_EQ(result.state, LocalizerState::kTracking) << result.problem;
}

TEST_F(LiveLocalizerTest, APoseThatWasJustGivenHoldsForTheSearchToo) {
  const auto map = std::make_shared<LocalizationMap>(test::furnishedRooms(), quickSearch());
  LiveLocalizer localizer(map);
  localizer.setPose(around(kView, 0.02, 0.01));
  localizer.process(input(0, here_));
  // The robot is carried away with a covered camera. Its new pose is given before the next image.
  localizer.setPose(around(kView, 0.4, 0.1));
  Pose odometry = Pose::Identity();
  odometry.translation().x() = 20;
  const LiveResult result = localizer.process(input(60, here_, odometry));
  const bool found = result.state == LocalizerState::kTracking || !result.clusters.empty();
  EXPECT_TRUE(found);
  for (const PoseCluster& cluster : result.clusters)
    EXPECT_LT((cluster.pose.translation() - kView.translation()).norm(), 3);
}

/// A clock that jumps ahead by a day, with odometry that goes on, does not move the pose.
TEST_F(LiveLocalizerTest, AClockThatJumpsADayAheadDoesNotMoveThePose) {
  LiveLocalizer localizer = begun(alone());
  for (int i = 0; i < 5; ++i) localizer.process(input(0.1 * i, here_));
  const LiveResult result = localizer.process(input(86400, here_));
  EXPECT_LT((result.estimate.mean.translation() - kView.translation()).norm(), 0.1);
  for (int i = 1; i < 15; ++i) localizer.process(input(86400 + 0.1 * i, here_));
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

/// The clock is wrong for a second. The pose is kept, and needs a new proof.
TEST_F(LiveLocalizerTest, AClockThatComesBackFromAJumpKeepsThePose) {
  LiveLocalizer localizer = begun(alone());
  double time = 0;
  const auto process = [&](double shift) {
    time += 0.1;
    return localizer.process(input(time + shift, here_));
  };
  for (int i = 0; i < 5; ++i) process(0);
  for (int i = 0; i < 10; ++i) process(86400);
  LiveResult result = process(0);
  EXPECT_TRUE(result.restarted);
  EXPECT_NE(result.problem.find("the pose is kept"), std::string::npos) << result.problem;
  for (int i = 0; i < 15; ++i) {
    result = process(0);
    EXPECT_LT((result.estimate.mean.translation() - kView.translation()).norm(), 0.1);
  }
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

/// Two equal cameras double the log-likelihood. The score per line stays the same.
TEST_F(LiveLocalizerTest, TwoCamerasThatSeeTheSameMakeNoLineWorthMore) {
  for (const LikelihoodModel model : {LikelihoodModel::kRobust, LikelihoodModel::kPaper}) {
    Parameters params;
    params.likelihood.model = model;
    const LocalizationMap map(test::furnishedRooms(), params);
    const CameraView view{map.prepare(camera_, here_, {}, "image"), Pose::Identity(), 1, nullptr};
    const PoseScore one = map.evaluate({view}, {kView}).front();
    const PoseScore two = map.evaluate({view, view}, {kView}).front();
    EXPECT_GT(one.line_count, 5);
    EXPECT_NEAR(two.scorePerLine(), one.scorePerLine(), 1e-6 * std::abs(one.scorePerLine()));
    EXPECT_NEAR(two.log_likelihood, 2 * one.log_likelihood, 1e-9 * std::abs(one.log_likelihood));
  }
}

/// A prepared image must not use the memory of the caller, which the caller may overwrite.
TEST_F(LiveLocalizerTest, APreparedImageIsItsOwn) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  // The memory belongs to a message or to the driver of a camera.
  cv::Mat buffer = here_.channels() == 1 ? here_.clone() : cv::Mat();
  if (buffer.empty()) cv::cvtColor(here_, buffer, cv::COLOR_BGR2GRAY);
  const cv::Mat before = buffer.clone();
  const cv::Mat wrapped(buffer.rows, buffer.cols, CV_8U, buffer.data, buffer.step);
  const auto image = map.prepare(camera_, wrapped, {}, "image");
  buffer.setTo(0);
  EXPECT_EQ(cv::norm(image->edges.grey, before, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace edge_mcl
