#include "edge_mcl/localization/tracking/calibration_checks.h"

#include <gtest/gtest.h>

#include "support/map_views.h"

namespace edge_mcl {
namespace {

CameraModel scaledCamera(double factor) {
  CameraModel camera = test::roomCamera();
  camera.fx *= factor;
  camera.fy *= factor;
  camera.validate("other camera");
  return camera;
}

class CalibrationChecksTest : public testing::Test {
 protected:
  /// What some moments tell, when the pose is the best one with a camera of another focal length.
  std::vector<std::string> look(double factor) {
    const CameraModel camera = scaledCamera(factor);
    const cv::Mat image = test::roomPicture();
    const std::vector<CameraView> views{
        {map_.prepare(camera, image, {}, "room"), Pose::Identity(), 1, nullptr}};
    const Pose pose = map_.refine(views, test::roomView(), std::nullopt).pose;
    std::vector<std::string> told;
    for (int i = 0; i < 8; ++i) {
      time_ += 1;
      if (checks_.note(camera, time_)) ++forgotten_;
      const std::string fault = checks_.look({map_, image, {}, Pose::Identity(), pose}, camera,
                                             factor > 1 ? -0.01 : 0.01, time_);
      if (!fault.empty()) told.push_back(fault);
    }
    return told;
  }

  LocalizationMap map_{test::furnishedRooms(), Parameters()};
  CalibrationChecks checks_;
  double time_ = 0;
  int forgotten_ = 0;
};

TEST_F(CalibrationChecksTest, ACorrectedCalibrationIsCheckedAnew) {
  ASSERT_EQ(look(1.05).size(), 1u);
  EXPECT_NEAR(checks_.focalError(), -0.045, 0.01);
  EXPECT_TRUE(look(1).empty());
  EXPECT_EQ(checks_.focalError(), 0);
  EXPECT_EQ(forgotten_, 1);
  // Another wrong one is told as well.
  EXPECT_EQ(look(0.95).size(), 1u);
  EXPECT_GT(checks_.focalError(), 0.03);
}

/// A lens that focuses by itself changes the focal length a little with every image.
TEST_F(CalibrationChecksTest, ALensThatFocusesIsNoOtherCalibration) {
  ASSERT_EQ(look(1.05).size(), 1u);
  for (int i = 0; i < 20; ++i)
    EXPECT_FALSE(checks_.note(scaledCamera(1.05 + 0.003 * (i % 2)), time_ += 1));
  EXPECT_LT(checks_.focalError(), -0.03);
}

/// The images of a second camera come in between, and some of the first one are missing.
TEST_F(CalibrationChecksTest, EachCameraHasItsOwnCalibration) {
  ASSERT_EQ(look(1.05).size(), 1u);
  for (int i = 0; i < 20; ++i) {
    time_ += 1;
    const bool is_missing = i % 3 == 0;
    EXPECT_FALSE(!is_missing && checks_.note(scaledCamera(1.05), time_));
    EXPECT_FALSE(checks_.note(scaledCamera(1), time_));
  }
  EXPECT_LT(checks_.focalError(), -0.03);
}

TEST_F(CalibrationChecksTest, AnotherLensIsAnotherCalibration) {
  ASSERT_EQ(look(1.05).size(), 1u);
  CameraModel camera = scaledCamera(1.05);
  camera.distortion = DistortionModel::kPlumbBob;
  camera.coefficients[0] = -0.1;
  camera.validate("distorted");
  bool forgets = false;
  for (int i = 0; i < 5; ++i) forgets = checks_.note(camera, time_ += 1) || forgets;
  EXPECT_TRUE(forgets);
  EXPECT_EQ(checks_.focalError(), 0);
}

}  // namespace
}  // namespace edge_mcl
