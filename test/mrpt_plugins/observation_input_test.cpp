#include "edge_mcl/mrpt_plugins/observation_input.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationOdometry.h>

#include <cmath>
#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "support/error_text.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationImage;
using mrpt::obs::CObservationOdometry;

const CameraModel& camera() {
  static const CameraModel made = test::pinhole(80, 60, 70);
  return made;
}

mrpt::img::CImage greyImage(int grey) {
  return {cv::Mat(60, 80, CV_8UC1, cv::Scalar(grey)), mrpt::img::DEEP_COPY};
}

/// A camera 0.2 m ahead of the base and 0.3 m above it.
const Pose kMounting = Pose(Eigen::Translation3d(0.2, 0, 0.3)) * opticalOnBody();

void fill(CObservationImage* image) {
  image->sensorLabel = "left";
  image->timestamp = mrpt::Clock::fromDouble(10);
  image->cameraParams = toMrpt(camera());
  image->cameraPose = toMrpt(kMounting);
  image->image = greyImage(90);
}

/// A range image in millimetres. @param range of every pixel
void fill(CObservation3DRangeScan* scan, uint16_t range) {
  scan->sensorLabel = "depth";
  scan->timestamp = mrpt::Clock::fromDouble(10);
  scan->cameraParams = toMrpt(camera());
  scan->hasRangeImage = true;
  scan->rangeUnits = 0.001f;
  scan->range_is_depth = true;
  scan->rangeImage_setSize(60, 80);
  scan->rangeImage.fill(range);
}

void addIntensity(CObservation3DRangeScan* scan) {
  scan->hasIntensityImage = true;
  scan->intensityImage = greyImage(50);
  scan->cameraParamsIntensity = toMrpt(camera());
}

TEST(ObservationInput, KnowsWhichObservationsHoldAnImageOrRanges) {
  CObservation3DRangeScan scan;
  EXPECT_FALSE(hasImage(scan));
  EXPECT_FALSE(hasDepth(scan));
  fill(&scan, 2000);
  EXPECT_TRUE(hasDepth(scan));
  addIntensity(&scan);
  EXPECT_TRUE(hasImage(scan));
  EXPECT_TRUE(hasImage(CObservationImage()));
  EXPECT_TRUE(hasImage(CObservationMaskedImage()));
  EXPECT_FALSE(hasDepth(CObservationImage()));
  const CObservationOdometry odometry;
  EXPECT_FALSE(hasImage(odometry) || hasDepth(odometry));
  EXPECT_FALSE(imageOf(odometry, nullptr));
  EXPECT_FALSE(depthOf(odometry));
  EXPECT_TRUE(rangesOf(odometry).empty());
}

TEST(ObservationInput, AnImageComesWithItsCameraAndMounting) {
  CObservationImage observation;
  fill(&observation);
  const auto image = imageOf(observation, nullptr);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->pixels.data, observation.image.asCvMatRef().data);  // no copy
  EXPECT_EQ(image->pixels.at<uint8_t>(3, 4), 90);
  EXPECT_TRUE(image->mask.empty());
  EXPECT_EQ(image->camera.width, 80);
  EXPECT_EQ(image->camera.fx, 70);
  EXPECT_TRUE(image->T_base_camera.isApprox(kMounting, 1e-12));
  EXPECT_EQ(originOf(observation), "image observation 'left'");
}

TEST(ObservationInput, AMaskedImageComesWithItsMask) {
  CObservationMaskedImage observation;
  fill(&observation);
  EXPECT_TRUE(imageOf(observation, nullptr)->mask.empty());
  observation.ignore_mask = greyImage(255);
  EXPECT_EQ(cv::countNonZero(imageOf(observation, nullptr)->mask), 80 * 60);
}

/// In MRPT the pose of the intensity camera is relative to the depth sensor. That sensor has x
/// forward, and the intensity camera has optical axes.
TEST(ObservationInput, TheIntensityImageHasAMountingOfItsOwn) {
  CObservation3DRangeScan scan;
  fill(&scan, 2000);
  addIntensity(&scan);
  const Pose sensor = expSe3((Twist() << 0.2, 0, 0.3, 0, 0.1, 0.2).finished());
  const Pose beside = Pose(Eigen::Translation3d(0, -0.025, 0)) * opticalOnBody();
  scan.sensorPose = toMrpt(sensor);
  scan.relativePoseIntensityWRTDepth = toMrpt(beside);
  const auto image = imageOf(scan, nullptr);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->pixels.at<uint8_t>(3, 4), 50);
  EXPECT_TRUE(image->T_base_camera.isApprox(sensor * beside, 1e-9));
  EXPECT_TRUE(depthMountingOf(scan).isApprox(sensor * opticalOnBody(), 1e-9));
  EXPECT_TRUE(depthOf(scan)->T_base_camera.isApprox(sensor * opticalOnBody(), 1e-9));
}

TEST(ObservationInput, AGivenCalibrationServesImagesWithoutOne) {
  CObservationImage observation;
  fill(&observation);
  CameraModel given = camera();
  given.fx = 99;
  EXPECT_EQ(imageOf(observation, &given)->camera.fx, 70);  // the image has its own
  observation.cameraParams.fx(0);
  observation.cameraParams.fy(0);
  EXPECT_EQ(imageOf(observation, &given)->camera.fx, 99);
  test::expectError<InputError>("'left': the image has no calibration",
                                [&] { imageOf(observation, nullptr); });
}

TEST(ObservationInput, ImagesThatCannotBeUsedAreErrors) {
  CObservationImage observation;
  fill(&observation);
  observation.cameraParams.nrows = 0;
  test::expectError<InputError>("'left'", [&] { imageOf(observation, nullptr); });
  fill(&observation);
  observation.image = mrpt::img::CImage();
  test::expectError<InputError>("'left': the image is empty",
                                [&] { imageOf(observation, nullptr); });
  observation.image.setExternalStorage("missing.png");
  const std::string text = test::errorText<InputError>([&] { imageOf(observation, nullptr); });
  EXPECT_PRED2(test::contains, text, "missing.png");
  EXPECT_EQ(text.find('\n'), std::string::npos) << text;
}

TEST(ObservationInput, DepthsAreTakenAsTheyAre) {
  CObservation3DRangeScan scan;
  fill(&scan, 2000);
  scan.rangeUnits = 0.0005f;
  const auto depth = depthOf(scan);
  ASSERT_TRUE(depth);
  EXPECT_EQ(depth->image.depth.type(), CV_16UC1);
  EXPECT_EQ(depth->image.depth.at<uint16_t>(5, 6), 2000);
  EXPECT_NEAR(depth->image.units_per_metre, 2000, 0.001);  // 0.0005 in single precision
  EXPECT_EQ(depth->image.camera.width, 80);
  EXPECT_EQ(depth->image.origin, "image observation 'depth'");
  EXPECT_EQ(rangesOf(scan).data, reinterpret_cast<uint8_t*>(scan.rangeImage.data()));  // no copy
}

/// A surface at the distance r along the ray (x, y, 1) has the depth r / sqrt(1 + x^2 + y^2).
TEST(ObservationInput, RangesAlongTheRaysBecomeDepths) {
  CObservation3DRangeScan scan;
  fill(&scan, 2000);
  scan.range_is_depth = false;
  scan.rangeImage(10, 20) = 0;  // no return
  const cv::Mat depth = depthOf(scan)->image.depth;
  ASSERT_EQ(depth.type(), CV_32FC1);
  for (int v = 0; v < 60; ++v)
    for (int u = 0; u < 80; ++u) {
      const double expected = v == 10 && u == 20 ? 0 : 2 / test::plainRay(camera(), u, v).norm();
      ASSERT_NEAR(depth.at<float>(v, u), expected, 1e-6) << u << " " << v;
    }
}

TEST(ObservationInput, RangeImagesThatCannotBeUsedAreErrors) {
  CObservation3DRangeScan scan;
  const auto expectFault = [&](const std::string& piece) {
    test::expectError<InputError>("'depth': " + piece, [&] { depthOf(scan); });
    fill(&scan, 2000);
  };
  fill(&scan, 2000);
  scan.rangeUnits = 0;
  expectFault("the range image has no unit");
  scan.rangeUnits = NAN;
  expectFault("the range image has no unit");
  scan.rangeImage_setSize(0, 0);
  expectFault("the range image is empty");
  scan.cameraParams.ncols = 0;
  expectFault("");
  scan.range_is_depth = false;
  scan.rangeImage_setSize(30, 40);
  expectFault("the range image and its camera have different sizes");
}

/// The key must change with everything that makes another image, and with nothing else.
TEST(ObservationKeys, AnotherImageHasAnotherKey) {
  CObservationMaskedImage observation, copy;
  fill(&observation);
  fill(&copy);
  const cv::Mat pixels = observation.image.asCvMatRef(), none;
  const uint64_t key = keyOf(observation, pixels, none);
  EXPECT_EQ(keyOf(observation, pixels, none), key);
  EXPECT_NE(keyOf(copy, pixels, none), key);
  EXPECT_NE(keyOf(observation, pixels, pixels), key);
  EXPECT_NE(keyOf(observation, pixels.rowRange(0, 59), none), key);
  observation.timestamp = mrpt::Clock::fromDouble(10.1);
  EXPECT_NE(keyOf(observation, pixels, none), key);
  observation.timestamp = mrpt::Clock::fromDouble(10);
  EXPECT_EQ(keyOf(observation, pixels, none), key);
  observation.image.asCvMatRef() = cv::Scalar(91);  // in the same memory
  EXPECT_NE(keyOf(observation, observation.image.asCvMatRef(), none), key);
}

TEST(ObservationKeys, AnotherRangeImageHasAnotherKey) {
  CObservation3DRangeScan scan;
  fill(&scan, 2000);
  const uint64_t key = depthKeyOf(scan);
  EXPECT_EQ(depthKeyOf(scan), key);
  std::vector<uint64_t> others;
  const auto change = [&](const auto& set) {
    set();
    EXPECT_NE(depthKeyOf(scan), key) << "change " << others.size();
    others.push_back(depthKeyOf(scan));
    scan.rangeUnits = 0.001f;
    scan.range_is_depth = true;
    scan.cameraParams = toMrpt(camera());
    scan.rangeImage.fill(2000);
    EXPECT_EQ(depthKeyOf(scan), key);
  };
  change([&] { scan.rangeUnits = 0.002f; });
  change([&] { scan.range_is_depth = false; });
  change([&] { scan.cameraParams.fx(71); });
  change([&] { scan.cameraParams.cy(31); });
  change([&] { scan.cameraParams.dist[0] = 0.1; });
  change([&] { scan.rangeImage.fill(2001); });
}

}  // namespace
}  // namespace edge_mcl
