#include <gtest/gtest.h>

#include <memory>

#include "edge_mcl/core/image/pixel_scale.h"
#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/scenario.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {
namespace {

/// Result of a flight on which a wrong detector masks the right half of every image: the number of
/// ignored pixels of every image, and the largest position error.
struct Flown {
  std::vector<int> ignored;
  std::vector<LocalizerState> before;  ///< before each image
  double worst = 0;                    ///< m, over the second half
};

Flown fly(bool lift_mask) {
  Scenario scenario = Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml");
  Parameters params;
  params.filter.particles = 300;
  params.tracking.lift_mask = lift_mask;
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, params);
  LiveLocalizer localizer(map);
  PoseGaussian start;
  start.mean = scenario.cameraAt(0);
  start.covariance.diagonal().head<3>().setConstant(0.0025);
  start.covariance.diagonal().tail<3>().setConstant(0.0005);
  localizer.setPose(start);
  Simulator simulator(scenario);
  RecordedFrame frame;
  Flown flown;
  constexpr int kImages = 30;
  for (int i = 0; i < kImages; ++i) {
    simulator.next(&frame);
    LiveInput input;
    input.time = frame.time;
    input.odometry = frame.odometry;
    cv::Mat mask = frame.mask.clone();
    mask.colRange(mask.cols / 2, mask.cols) = 255;
    input.images.push_back({scenario.camera, frame.color, mask, Pose::Identity(), "image"});
    flown.before.push_back(localizer.state());
    const LiveResult result = localizer.process(input);
    flown.ignored.push_back(cv::countNonZero(result.images.at(0)->edges.ignore));
    if (i >= kImages / 2)
      flown.worst = std::max(
          flown.worst, (result.estimate.mean.translation() - frame.truth->translation()).norm());
  }
  return flown;
}

/// The flight is run with and without lifting. The ignored pixels are compared image by image.
TEST(MaskLifting, BeginsWithTrackingAndOnlyWhereItIsWanted) {
  const Flown with = fly(true), without = fly(false);
  size_t tracked = 0, lifted = 0;
  for (size_t i = 0; i < with.ignored.size(); ++i) {
    tracked += with.before[i] == LocalizerState::kTracking ? 1 : 0;
    if (tracked > 3) {  // three images must show a line before the mask is lifted
      lifted += with.ignored[i] < without.ignored[i] ? 1 : 0;
    } else {
      EXPECT_EQ(with.ignored[i], without.ignored[i]) << "image " << i;
    }
  }
  EXPECT_GE(tracked, 20u);
  EXPECT_EQ(lifted, tracked - 3);
  // Lifting brings up to twice as much of the room into use. The position errors stay small.
  EXPECT_LT(with.worst, 0.05);
  EXPECT_LT(without.worst, 0.10);
}

/// A flight that is tracked from its true start.
class TrackedFlight {
 public:
  TrackedFlight() {
    PoseGaussian start;
    start.mean = scenario_.cameraAt(0);
    start.covariance.diagonal().setConstant(1e-4);
    localizer.setPose(start);
  }
  /// The next image, with an empty mask.
  LiveInput next() {
    RecordedFrame frame;
    simulator_.next(&frame);
    LiveInput input;
    input.time = frame.time;
    input.odometry = frame.odometry;
    const cv::Mat mask(frame.color.size(), CV_8UC1, cv::Scalar(0));
    input.images = {{scenario_.camera, frame.color, mask, Pose::Identity(), "front"}};
    return input;
  }

 private:
  const Scenario scenario_ =
      Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml");
  Simulator simulator_{scenario_};

 public:
  const std::shared_ptr<LocalizationMap> map =
      std::make_shared<LocalizationMap>(scenario_.model_file, Parameters());
  LiveLocalizer localizer{map};
};

/// Lines are known by their numbers in the map. In another map the same number is another line.
TEST(MaskLifting, BeginsAnewInAnotherMap) {
  TrackedFlight flight;
  std::vector<int> shares;  // ignored pixels, per mille of those without lifting
  for (int i = 0; i < 10; ++i) {
    if (i == 8) flight.localizer.setMap(flight.map);
    const LiveInput input = flight.next();
    cv::Mat mask = input.images[0].mask;
    mask.colRange(mask.cols / 2, mask.cols) = 255;
    const LiveResult result = flight.localizer.process(input);
    const ImageParameters& params = flight.map->params().image;
    const cv::Mat whole = ignoredPixels(mask, mask.size(),
                                        scaledBy(pixelScale(params, mask.size()), params), "image");
    shares.push_back(1000 * cv::countNonZero(result.images.at(0)->edges.ignore) /
                     cv::countNonZero(whole));
  }
  ASSERT_EQ(flight.localizer.state(), LocalizerState::kTracking);
  EXPECT_LT(shares[7], 1000);
  EXPECT_EQ(shares[8], 1000);
}

/// An image that cannot be used is reported with its name, with or without a mask.
TEST(MaskLifting, LeavesABadImageToBeReported) {
  TrackedFlight flight;
  for (int i = 0; i < 6; ++i) flight.localizer.process(flight.next());
  ASSERT_EQ(flight.localizer.state(), LocalizerState::kTracking);
  LiveInput input = flight.next();
  LiveInput::CameraImage& view = input.images[0];
  view.image = cv::Mat(view.image.size(), CV_32FC2, cv::Scalar(0));
  view.mask.colRange(0, 100) = 255;
  EXPECT_NE(flight.localizer.process(input).problem.find("front"), std::string::npos);
}

}  // namespace
}  // namespace edge_mcl
