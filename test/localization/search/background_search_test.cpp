// The pose is looked for while images go on. How far the search gets depends on the machine, so the
// flight goes to and fro until it is found, or for much longer than that takes.
#include "edge_mcl/localization/search/background_search.h"

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

constexpr double kDegree = M_PI / 180;
constexpr auto kPeriod = std::chrono::milliseconds(66);  // 15 images a second

/// Goes through a recorded flight to and fro, without a break in its motion.
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
    input.views.push_back({camera_, frame().color, frame().mask, Pose::Identity(), "image"});
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
  // Of this very image, though an older one was worked at.
  EXPECT_TRUE(isRight(result));
  EXPECT_GT(images, result.search_keyframes);
  for (int i = 0; i < 60; ++i) {
    result = localizer.process(flight_.next());
    EXPECT_TRUE(isRight(result)) << "image " << i << " after";
  }
  EXPECT_EQ(result.state, LocalizerState::kTracking);
}

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

/// The search alone.
class BackgroundSearchAlone : public BackgroundSearchTest {
 protected:
  BackgroundSearch search_{*map_, 1};

  SearchReport offer() {
    const LiveInput input = flight_.next();
    const LiveInput::View& view = input.views.front();
    CameraView seen;
    seen.image = map_->prepare(view.camera, view.image, view.mask, view.origin);
    return search_.process({seen}, input.up);
  }
  SearchReport awaitNews() {
    for (int i = 0; i < 3000; ++i) {
      const SearchReport report = offer();
      if (report.keyframe) return report;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return {};
  }
};

// What an older search finds must not be taken for an answer to a newer question.
TEST_F(BackgroundSearchAlone, BeginsAnewWhileItThinks) {
  search_.begin();
  EXPECT_EQ(awaitNews().keyframes, 1);
  for (int i = 0; i < 5; ++i) {
    search_.begin();
    offer();  // worked at when it begins anew
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
  }
  search_.begin();
  const SearchReport first = offer();
  EXPECT_FALSE(first.keyframe);
  EXPECT_TRUE(first.clusters.empty());
  EXPECT_EQ(awaitNews().keyframes, 1);
  offer();  // and ends while something is worked at
}

TEST_F(BackgroundSearchAlone, OdometryCarriesWhatItFoundToThePresent) {
  search_.begin();
  const SearchReport then = awaitNews();
  ASSERT_EQ(then.keyframes, 1);
  ASSERT_FALSE(then.clusters.empty());
  const FilterParameters& p = map_->params().filter;
  // Less than a new view, in two steps.
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
  // Odometry drifts: on a busy machine it carried a pose for ten seconds, to 0.29 m from the truth.
  for (int i = 0; i < 60; ++i)
    search_.move(BaseMotion::of(p, expSe3((Twist() << 0.05, 0, 0, 0, 0, 0.01).finished()), 0.1));
  EXPECT_TRUE(offer().stale);
}

TEST_F(BackgroundSearchAlone, WhatItFoundBeforeAGapOfOdometryIsStale) {
  search_.begin();
  ASSERT_EQ(awaitNews().keyframes, 1);
  const FilterParameters& p = map_->params().filter;
  // Half a second: it may be anywhere around.
  search_.move(BaseMotion::of(p, std::nullopt, 0.5));
  EXPECT_TRUE(offer().stale);
}

// After a search of ten seconds the next view was ten seconds of flight away; a pose followed over
// that, and through two more views, was 0.36 m off and called tracking.
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
