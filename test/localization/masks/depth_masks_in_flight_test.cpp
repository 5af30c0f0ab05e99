// Masks by depth in a simulated flight with a person who walks. The truth is the simulator's.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/simulator.h"
#include "support/flight_input.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

class DepthMasksInFlight : public testing::Test {
 protected:
  const Scenario scenario_ =
      Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml");
  Simulator simulator_{scenario_};
  RandomSource random_{5};
  RecordedFrame frame_;

  LiveLocalizer localizer() const {
    Parameters params = quickSearch();
    params.tracking.mask_by_depth = true;
    params.search.recover = false;
    return LiveLocalizer(std::make_shared<LocalizationMap>(scenario_.model_file, params));
  }
  /// The next moment of the flight, without the simulator's masks.
  LiveInput next() {
    simulator_.next(&frame_);
    LiveInput input = test::inputOf(frame_, scenario_.camera, &random_);
    input.images.front().mask = cv::Mat();
    LiveInput::Depth depth;
    depth.image.camera = scenario_.camera;
    depth.image.depth = frame_.depth;
    depth.image.units_per_metre = scenario_.depth_scale;
    depth.image.origin = "depth";
    input.depths.push_back(depth);
    return input;
  }
  static PoseGaussian around(const Pose& mean) {
    PoseGaussian pose;
    pose.mean = mean;
    pose.covariance.diagonal().head<3>().setConstant(0.01);
    pose.covariance.diagonal().tail<3>().setConstant(0.002);
    return pose;
  }
  static double share(const cv::Mat& mask) {
    return cv::countNonZero(mask) / static_cast<double>(mask.total());
  }
};

/// Most of the person is masked. Feet stand too near to the floor, and legs behind a desk are
/// beside the desk's own edges: together an eighth of it. Masked beside the person is only a
/// margin: at most as far as 12 pixels, the spacing of the depth pixels and both dilations.
TEST_F(DepthMasksInFlight, ThePersonIsMaskedAndNothingElse) {
  LiveLocalizer localizer = this->localizer();
  int with_person = 0;
  double person = 0, masked = 0;
  for (size_t i = 0; i < simulator_.imageCount(); ++i) {
    const LiveInput input = next();
    if (i == 0) localizer.setPose(around(*frame_.truth));
    const LiveResult result = localizer.process(input);
    EXPECT_EQ(result.state, LocalizerState::kTracking) << "image " << i << ": " << result.problem;
    ASSERT_FALSE(result.images.empty());
    const cv::Mat& used = result.images.front()->edges.ignore;
    cv::Mat around_person, both;
    cv::dilate(frame_.mask, around_person, cv::Mat::ones(25, 25, CV_8U));
    if (used.empty()) continue;
    cv::bitwise_and(used, ~around_person, both);
    EXPECT_LE(share(both), 0.001) << "image " << i;
    if (share(frame_.mask) < 0.01) continue;
    ++with_person;
    cv::bitwise_and(used, frame_.mask, both);
    person += share(frame_.mask);
    masked += share(both);
  }
  EXPECT_GT(with_person, 20);
  EXPECT_GT(masked, 0.85 * person);
}

/// From a wrong pose the building is in front of the model. It must not be masked.
TEST_F(DepthMasksInFlight, AWrongPoseMasksNothing) {
  LiveLocalizer localizer = this->localizer();
  int wrong_images = 0;
  for (size_t i = 0; i < 30; ++i) {
    const LiveInput input = next();
    if (i == 0) {
      Pose wrong = *frame_.truth;
      wrong.pretranslate(Eigen::Vector3d(0.4, 0.3, 0));
      wrong.linear() = Eigen::AngleAxisd(20 * kDegree, Eigen::Vector3d::UnitZ()) * wrong.linear();
      localizer.setPose(around(wrong));
    }
    const LiveResult result = localizer.process(input);
    if (!test::isRight(result.estimate.mean, *frame_.truth)) {
      EXPECT_EQ(result.foreign_share, 0);
      ++wrong_images;
    }
  }
  EXPECT_GT(wrong_images, 3) << "the pose was not wrong for long enough to tell";
}

/// A depth image that cannot be used is told. Localization goes on without masks.
TEST_F(DepthMasksInFlight, ABrokenDepthImageIsTold) {
  LiveLocalizer localizer = this->localizer();
  for (size_t i = 0; i < 5; ++i) {
    LiveInput input = next();
    input.depths.front().image.depth = cv::Mat(10, 10, CV_32F);
    if (i == 0) localizer.setPose(around(*frame_.truth));
    const LiveResult result = localizer.process(input);
    EXPECT_NE(result.problem.find("depth"), std::string::npos);
    EXPECT_TRUE(result.updated);
    EXPECT_EQ(result.foreign_share, 0);
  }
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

}  // namespace
}  // namespace edge_mcl
