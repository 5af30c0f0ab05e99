// Searches that begin with little: no odometry, or a rough guess.
#include <gtest/gtest.h>

#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/simulator.h"
#include "support/flight_input.h"
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
  const auto foundAfter = [&](double glance_period) {
    Simulator simulator(scenario);
    Parameters params = quickSearch();
    params.search.glance_period = glance_period;
    LiveLocalizer localizer(std::make_shared<LocalizationMap>(scenario.model_file, params));
    localizer.searchEverywhere();
    RandomSource random(5);
    RecordedFrame frame;
    size_t found = 0, right = 0, after = 0;
    for (size_t i = 0; i < simulator.imageCount(); ++i) {
      simulator.next(&frame);
      LiveInput input = inputOf(frame, scenario.camera, &random);
      input.odometry.reset();
      const LiveResult r = localizer.process(input);
      if (!localizer.isInitialized()) continue;
      if (++after == 1) found = i;
      right += isRight(r.estimate.mean, *frame.truth) ? 1 : 0;
    }
    EXPECT_EQ(right, after);
    return after > 0 ? found : simulator.imageCount();
  };
  const size_t blind = foundAfter(10), seeing = foundAfter(0.1);
  EXPECT_LE(seeing, 15u) << "of 61 images; without glances after " << blind;
  EXPECT_LT(seeing, blind);
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

}  // namespace
}  // namespace edge_mcl
