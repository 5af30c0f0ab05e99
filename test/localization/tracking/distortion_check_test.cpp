#include "edge_mcl/localization/tracking/distortion_check.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "support/map_views.h"

namespace edge_mcl {
namespace {

/// A lens that moves the corners of roomCamera()'s image by 15 pixels.
CameraModel lens() {
  CameraModel camera = test::roomCamera();
  camera.distortion = DistortionModel::kPlumbBob;
  camera.coefficients = {-0.1, 0, 0, 0, 0, 0, 0, 0};
  camera.validate("lens");
  return camera;
}

/// roomPicture() as the lens shows it, by OpenCV.
cv::Mat bentPicture() {
  const CameraModel c = lens();
  std::vector<cv::Point2f> pixels, straight;
  for (int v = 0; v < c.height; ++v)
    for (int u = 0; u < c.width; ++u) pixels.emplace_back(u, v);
  const cv::Mat k = (cv::Mat_<double>(3, 3) << c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const cv::Mat d = (cv::Mat_<double>(1, 4) << c.coefficients[0], 0, 0, 0);
  cv::undistortPoints(pixels, straight, k, d, cv::noArray(), k);
  const cv::Mat places = cv::Mat(straight).reshape(2, c.height);
  cv::Mat bent;
  cv::remap(test::roomPicture(), bent, places, cv::noArray(), cv::INTER_LINEAR,
            cv::BORDER_REPLICATE);
  return bent;
}

/// How many of some moments tell that images have no distortion.
int told(const LocalizationMap& map, const CameraModel& camera, const cv::Mat& image) {
  DistortionCheck check;
  int count = 0;
  for (int i = 0; i < 20; ++i)
    count += check.look({map, image, {}, Pose::Identity(), test::roomView()}, camera, i) ? 1 : 0;
  return count;
}

TEST(DistortionCheck, TellsOnceThatImagesAreRectified) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  EXPECT_EQ(told(map, lens(), test::roomPicture()), 1);
}

TEST(DistortionCheck, IsSilentWhereCalibrationAndImagesBelongTogether) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  EXPECT_EQ(told(map, lens(), bentPicture()), 0);
  EXPECT_EQ(told(map, test::roomCamera(), test::roomPicture()), 0);
}

/// Nothing can be told from an image without edges, nor from neighbouring images.
TEST(DistortionCheck, OneImageOrADarkOneTellsNothing) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const cv::Mat dark(test::roomCamera().height, test::roomCamera().width, CV_8U, cv::Scalar(0));
  EXPECT_EQ(told(map, lens(), dark), 0);
  DistortionCheck check;
  for (int i = 0; i < 20; ++i)
    EXPECT_FALSE(check.look({map, test::roomPicture(), {}, Pose::Identity(), test::roomView()},
                            lens(), 1 + 1e-3 * i));
}

/// A distortion of less than a pixel cannot be seen, so no time is spent on it.
TEST(DistortionCheck, DoesNotAskForLittleDistortion) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  CameraModel camera = lens();
  camera.coefficients[0] = -0.005;
  camera.validate("lens");
  EXPECT_EQ(told(map, camera, test::roomPicture()), 0);
}

}  // namespace
}  // namespace edge_mcl
