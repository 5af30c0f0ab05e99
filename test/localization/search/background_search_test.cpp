// The search runs in its own thread while images go on. How far it gets depends on the machine. So
// the flight goes to and fro until the pose is found, or until a limit that is much longer than the
// search takes.
#include "edge_mcl/localization/search/background_search.h"
#include "edge_mcl/core/base/angles.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/search/pose_sharpener.h"
#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/simulator.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(66);  // 15 images a second

/// Gives the images of a recorded flight to and fro, without a jump in its motion.
class ToAndFro {
 public:
  explicit ToAndFro(const Scenario& scenario) : camera_(scenario.camera) {
    Simulator simulator(scenario);
    for (size_t i = 0; i < simulator.imageCount(); ++i) {
      RecordedFrame frame;
      simulator.next(&frame);
      frames_.push_back(frame);
    }
  }

  LiveInput next() {
    at_ = (at_ + 1) % (2 * frames_.size() - 2);
    time_ += 1.0 / 15;
    LiveInput input;
    input.time = time_;
    input.odometry = frame().odometry;
    input.up = UpReading{frame().truth->linear().transpose() * Eigen::Vector3d::UnitZ(), kDegree};
    input.images.push_back({camera_, frame().color, frame().mask, Pose::Identity(), "image"});
    return input;
  }

  const Pose& truth() const { return *frame().truth; }

 private:
  const RecordedFrame& frame() const {
    return frames_[at_ < frames_.size() ? at_ : 2 * frames_.size() - 2 - at_];
  }

  CameraModel camera_;
  std::vector<RecordedFrame> frames_;
  size_t at_ = 0;
  double time_ = 0;
};

class BackgroundSearchTest : public testing::Test {
 protected:
  static constexpr int kMostImages = 1500;
  const Scenario scenario_ =
      Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml");
  const std::shared_ptr<LocalizationMap> map_ =
      std::make_shared<LocalizationMap>(scenario_.model_file, quickSearch());
  ToAndFro flight_{scenario_};

  bool isRight(const LiveResult& result) const {
    return isNear(result.estimate.mean, flight_.truth(), 0.25, 5 * kDegree);
  }
};

/// The truth is the pose of the simulator, see isRight().
TEST_F(BackgroundSearchTest, FindsTheCameraWhileImagesGoOn) {
  LiveLocalizer localizer(map_, true);
  localizer.searchEverywhere();
  int images = 0;
  LiveResult result;
  do {
    result = localizer.process(flight_.next());
    std::this_thread::sleep_for(kPeriod);
  } while (!result.relocalized && ++images < kMostImages);
  ASSERT_TRUE(result.relocalized);
  // The pose must be the pose at this image, though the search used an older one.
  EXPECT_TRUE(isRight(result));
  EXPECT_GT(images, result.search_keyframes);
  for (int i = 0; i < 60; ++i) {
    result = localizer.process(flight_.next());
    EXPECT_TRUE(isRight(result)) << "image " << i << " after";
  }
  EXPECT_EQ(result.state, LocalizerState::kTracking);
}

/// Places 10 cm apart take minutes to prepare. A search around a guess does without them
/// meanwhile. The end of the localizer ends the preparation, too.
TEST_F(BackgroundSearchTest, AroundAGuessItDoesNotWaitForPreparedPlaces) {
  Parameters params = quickSearch();
  params.search.prepared_spacing = 0.1;
  params.search.prepared_megabytes = 4000;
  params.search.store_places = false;
  LiveLocalizer localizer(std::make_shared<LocalizationMap>(scenario_.model_file, params), true);
  localizer.prepareSearch();
  PoseGaussian guess;
  LiveInput input = flight_.next();
  guess.mean = flight_.truth();
  guess.mean.translation().x() += 0.4;
  guess.covariance.diagonal() << 0.16, 0.16, 0.16, 0.02, 0.02, 0.07;
  localizer.searchAround(guess);
  LiveResult result;
  constexpr int kSoon = 150;  // images; ten seconds
  int images = 0;
  do {
    result = localizer.process(input);
    input = flight_.next();
    std::this_thread::sleep_for(kPeriod);
  } while (!result.relocalized && ++images < kSoon);
  EXPECT_TRUE(result.relocalized);
}

/// Nothing but the images carries the result of the search to the present.
TEST_F(BackgroundSearchTest, FindsTheCameraWithoutOdometry) {
  LiveLocalizer localizer(map_, true);
  localizer.searchEverywhere();
  LiveResult result;
  int tracked = 0;
  for (int images = 0; tracked < 30 && images < kMostImages; ++images) {
    LiveInput input = flight_.next();
    input.odometry.reset();
    result = localizer.process(input);
    if (result.state == LocalizerState::kTracking) {
      ++tracked;
      EXPECT_TRUE(isRight(result)) << "image " << images;
    }
    std::this_thread::sleep_for(kPeriod);
  }
  EXPECT_EQ(tracked, 30);
}

/// The filter starts 5 m away from the true pose. It must become lost, and then the search must
/// find the pose.
TEST_F(BackgroundSearchTest, FindsItAgainAfterItWasCarriedElsewhere) {
  LiveLocalizer localizer(map_, true);
  PoseGaussian elsewhere;
  elsewhere.mean = scenario_.cameraAt(0);
  elsewhere.mean.pretranslate(Eigen::Vector3d(5, 1.5, 0));
  elsewhere.covariance.diagonal().head<3>().setConstant(0.01);
  elsewhere.covariance.diagonal().tail<3>().setConstant(0.002);
  localizer.setPose(elsewhere);
  bool lost = false;
  int tracked = 0;
  for (int images = 0; tracked < 10 && images < kMostImages; ++images) {
    const LiveResult result = localizer.process(flight_.next());
    lost |= result.state == LocalizerState::kLost;
    if (result.state == LocalizerState::kTracking) {
      ++tracked;
      EXPECT_TRUE(isRight(result)) << "image " << images;
    }
    std::this_thread::sleep_for(kPeriod);
  }
  EXPECT_TRUE(lost);
  EXPECT_EQ(tracked, 10);
}

/// Tests the search without a filter.
class BackgroundSearchAlone : public BackgroundSearchTest {
 protected:
  BackgroundSearch search_{*map_, 1};

  SearchReport offer() {
    const LiveInput input = flight_.next();
    const LiveInput::CameraImage& view = input.images.front();
    CameraView seen;
    seen.image = map_->prepare(view.camera, view.image, view.mask, view.origin);
    return search_.process({seen}, input.up);
  }
  SearchReport awaitNews() {
    for (int i = 0; i < 3000; ++i) {
      SearchReport report = offer();
      if (report.keyframe) return report;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return {};
  }
};

/// The result of an older search must not be taken for the result of a newer one.
TEST_F(BackgroundSearchAlone, BeginsAnewWhileItThinks) {
  search_.begin();
  EXPECT_EQ(awaitNews().keyframes, 1);
  for (int i = 0; i < 5; ++i) {
    search_.begin();
    offer();  // the thread works on this image when the search begins anew
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  search_.begin();
  const SearchReport first = offer();
  EXPECT_FALSE(first.keyframe);
  EXPECT_TRUE(first.clusters.empty());
  EXPECT_EQ(awaitNews().keyframes, 1);
  offer();  // the search ends while its thread works on an image
}

/// The truth is the product of the steps.
TEST_F(BackgroundSearchAlone, OdometryCarriesWhatItFoundToThePresent) {
  search_.begin();
  const SearchReport then = awaitNews();
  ASSERT_EQ(then.keyframes, 1);
  ASSERT_FALSE(then.clusters.empty());
  const FilterParameters& p = map_->params().filter;
  // Two steps move the camera, but less than the distance that makes a keyframe.
  const Pose step = expSe3((Twist() << 0.02, -0.01, 0.03, 0.01, -0.02, 0.01).finished());
  search_.move(BaseMotion::of(p, step, 0.1));
  search_.move(BaseMotion::of(p, step, 0.1));
  const SearchReport now = offer();
  const Pose both = step * step;
  EXPECT_FALSE(now.keyframe);
  EXPECT_FALSE(now.stale);
  EXPECT_TRUE(now.estimate.mean.isApprox(then.estimate.mean * both, 1e-9));
  EXPECT_TRUE(now.clusters.front().pose.isApprox(then.clusters.front().pose * both, 1e-9));
  EXPECT_GT(now.estimate.covariance.trace(), then.estimate.covariance.trace());
  // Odometry drifts. On a busy machine it once carried a pose for ten seconds, to 0.29 m from the
  // truth. So a pose that is carried too far is stale.
  for (int i = 0; i < 60; ++i)
    search_.move(BaseMotion::of(p, expSe3((Twist() << 0.05, 0, 0, 0, 0, 0.01).finished()), 0.1));
  EXPECT_TRUE(offer().stale);
}

TEST_F(BackgroundSearchAlone, WhatItFoundBeforeAGapOfOdometryIsStale) {
  search_.begin();
  ASSERT_EQ(awaitNews().keyframes, 1);
  const FilterParameters& p = map_->params().filter;
  // For half a second there is no odometry, so the camera may be anywhere around.
  search_.move(BaseMotion::of(p, std::nullopt, 0.5));
  EXPECT_TRUE(offer().stale);
}

/// When a keyframe takes ten seconds, the next keyframe is ten seconds of flight away. Once a pose
/// was followed over this gap and through two more keyframes. It had an error of 0.36 m and was
/// called tracking.
TEST_F(BackgroundSearchAlone, WhatItFollowedOverAGapBetweenViewsIsStale) {
  const FilterParameters& p = map_->params().filter;
  const auto fly = [&](int steps) {
    for (int i = 0; i < steps; ++i)
      search_.move(BaseMotion::of(p, expSe3((Twist() << 0.05, 0, 0, 0, 0, 0.01).finished()), 0.1));
  };
  search_.begin();
  ASSERT_EQ(awaitNews().keyframes, 1);
  fly(10);
  SearchReport report = awaitNews();
  EXPECT_EQ(report.keyframes, 2);
  EXPECT_FALSE(report.stale);
  fly(60);
  EXPECT_TRUE(awaitNews().stale);
  fly(10);
  report = awaitNews();
  EXPECT_EQ(report.keyframes, 4);
  EXPECT_TRUE(report.stale);
  search_.begin();
  EXPECT_FALSE(awaitNews().stale);
}

/// The model is a plate without an inside, so there is no place to search. The error of the search
/// thread must be reported.
TEST_F(BackgroundSearchTest, WhatGoesWrongIsTold) {
  MeshSoup plate;
  plate.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  plate.triangles = {{0, 1, 2}, {0, 2, 3}};
  plate.triangle_material = {0, 0};
  LiveLocalizer localizer(
      std::make_shared<LocalizationMap>(weldMesh(std::move(plate), 1e-6, "test"), Parameters()),
      true);
  localizer.searchEverywhere();
  std::string problem;
  for (int i = 0; i < 1000 && problem.find("search.clearance") == std::string::npos; ++i) {
    problem = localizer.process(flight_.next()).problem;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_NE(problem.find("search.clearance"), std::string::npos) << problem;
}

}  // namespace
}  // namespace edge_mcl
