// Searches that begin with little: no odometry, or a rough guess.
#include <gtest/gtest.h>

#include "edge_mcl/localization/search/global_localizer.h"
#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/simulator.h"
#include "support/flight_input.h"
#include "support/map_views.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

using test::inputOf;
using test::isRight;
const std::string kData = EDGE_MCL_TEST_DATA;

/// A video has no odometry. Between two keyframes half a second apart the camera turns and moves
/// farther than a refinement reaches, so hypotheses must be followed through the images between.
TEST(Search, WithoutOdometryTheImagesTellTheMotion) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  struct Images {
    int right = 0, wrong = 0;  // of those that are tracked
  };
  const auto fly = [&](double glance_period) {
    Simulator simulator(scenario);
    Parameters params = quickSearch();
    params.search.glance_period = glance_period;
    LiveLocalizer localizer(std::make_shared<LocalizationMap>(scenario.model_file, params));
    localizer.searchEverywhere();
    RandomSource random(5);
    RecordedFrame frame;
    Images images;
    for (size_t i = 0; i < simulator.imageCount(); ++i) {
      simulator.next(&frame);
      LiveInput input = inputOf(frame, scenario.camera, &random);
      input.odometry.reset();
      const LiveResult r = localizer.process(input);
      if (r.state != LocalizerState::kTracking) continue;
      ++(isRight(r.estimate.mean, *frame.truth) ? images.right : images.wrong);
    }
    return images;
  };
  const Images blind = fly(10), seeing = fly(0.1);
  EXPECT_EQ(seeing.wrong, 0);
  EXPECT_GE(seeing.right, 46) << "of 61 images: found within a second";
  EXPECT_LT(blind.right, seeing.right);
}

/// A guess that is too rough for particles: the pose is searched there first. Where the guess is
/// wrong, the whole model is searched later.
TEST(Search, ARoughGuessIsSearchedThereFirst) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  for (const bool is_right : {true, false}) {
    Simulator simulator(scenario);
    LiveLocalizer localizer(map);
    RandomSource random(5);
    RecordedFrame frame;
    size_t found = 0;
    for (size_t i = 0; i < simulator.imageCount() && found == 0; ++i) {
      simulator.next(&frame);
      if (i == 0) {
        PoseGaussian guess;
        guess.mean = *frame.truth;
        guess.mean.translation().x() += is_right ? 0.5 : 4;
        guess.covariance.diagonal() << 0.25, 0.25, 0.25, 0.02, 0.02, 0.07;
        localizer.searchAround(guess);
        EXPECT_EQ(localizer.state(), LocalizerState::kSearching);
      }
      const LiveResult r = localizer.process(inputOf(frame, scenario.camera, &random));
      if (!localizer.isInitialized()) continue;
      found = i;
      EXPECT_TRUE(isRight(r.estimate.mean, *frame.truth));
    }
    EXPECT_GT(found, 0u);
    EXPECT_LE(found, is_right ? 20u : 60u);
  }
}

/// A user gives a pose while the robot stands still. Odometry tells no motion, so keyframes come by
/// time.
TEST(Search, ARoughGuessIsFoundAtRestToo) {
  constexpr double kEvery = 0.1;  // s
  const Parameters params = quickSearch();
  const LocalizationMap map(test::furnishedRooms(), params);
  const std::vector<CameraView> views{test::viewInRoom(map)};
  PoseGaussian guess;
  guess.mean = test::roomView();
  guess.mean.translation().x() += 0.2;
  guess.covariance.diagonal() << 0.25, 0.25, 0.25, 0.003, 0.003, 0.07;
  GlobalLocalizer search(map, 7);
  search.begin(guess, true);
  SearchReport report;
  int images = 0;
  do {
    search.move(BaseMotion::of(params.filter, Pose::Identity(), kEvery));
    report = search.process(views, std::nullopt);
  } while (!report.converged && ++images < 40);
  EXPECT_TRUE(report.converged);
  EXPECT_TRUE(isRight(report.estimate.mean, test::roomView()));
  EXPECT_LE(images, 20);
}

/// The robot rests, and its first image is dark. So hypotheses stay beside the pose until the
/// second image moves them onto it, which is no motion of the robot. A refined pose is right to
/// about a centimetre, which is 0.02 m/s over the time between the images. The guesses are 0.3 m
/// off, which would be 0.6 m/s.
TEST(Search, AHypothesisThatMovesOntoThePoseHasNoVelocity) {
  constexpr double kMost = 0.1;   // m/s
  constexpr double kEvery = 0.5;  // s
  const Parameters params = quickSearch();
  const LocalizationMap map(test::furnishedRooms(), params);
  const std::vector<CameraView> dark{test::darkView(map)}, lit{test::viewInRoom(map)};
  RandomSource random(5);
  int told = 0;
  for (int start = 0; start < 3; ++start) {
    PoseGaussian guess;
    guess.mean = test::roomView();
    guess.mean.translation() += 0.3 * random.direction();
    guess.covariance.diagonal() << 0.04, 0.04, 0.04, 0.003, 0.003, 0.003;
    GlobalLocalizer search(map, 7 + start);
    search.begin(guess, true);
    search.process(dark, std::nullopt);
    search.move(BaseMotion::of(params.filter, std::nullopt, kEvery));
    const SearchReport report = search.process(lit, std::nullopt);
    if (!report.velocity) continue;
    ++told;
    EXPECT_LT(report.velocity->head<3>().norm(), kMost) << "start " << start;
  }
  EXPECT_GT(told, 0);
}

}  // namespace
}  // namespace edge_mcl
