#include "edge_mcl/core/camera/mask_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// A mask of a few shapes, one of which touches the border of the image.
cv::Mat someMask() {
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8U);
  cv::circle(mask, {100, 90}, 30, cv::Scalar(255), cv::FILLED);
  cv::rectangle(mask, {200, 150}, {319, 200}, cv::Scalar(255), cv::FILLED);
  return mask;
}

Eigen::Matrix3d turn(double degrees, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(degrees * M_PI / 180, axis.normalized()).toRotationMatrix();
}

/// Value of a pixel now: its ray, turned back into the older camera, is projected into the older
/// mask. -1: the ray lies within a pixel of a border of the mask, where rounding decides.
int lookUp(const cv::Mat& mask, const CameraModel& camera, const Eigen::Matrix3d& R_now_then, int x,
           int y) {
  const Eigen::Vector3d then = R_now_then.transpose() * test::plainRay(camera, x, y);
  Eigen::Vector2d pixel;
  if (!camera.project(then, &pixel)) return 0;
  const int u = static_cast<int>(std::lround(pixel.x())),
            v = static_cast<int>(std::lround(pixel.y()));
  const cv::Rect image(0, 0, mask.cols, mask.rows), around(u - 1, v - 1, 3, 3);
  if ((around & image).empty()) return 0;
  const int set = cv::countNonZero(mask(around & image));
  if (set == 0) return 0;
  return set == around.area() ? mask.at<uint8_t>(v, u) : -1;
}

void expectTurned(const Eigen::Matrix3d& R_now_then) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  const cv::Mat mask = someMask();
  const cv::Mat turned = turnMask(mask, camera, R_now_then);
  ASSERT_EQ(turned.size(), mask.size());
  ASSERT_EQ(turned.type(), CV_8UC1);
  int undecided = 0;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      const int expected = lookUp(mask, camera, R_now_then, x, y);
      undecided += expected < 0;
      if (expected >= 0) {
        ASSERT_EQ(turned.at<uint8_t>(y, x), expected) << x << " " << y;
      }
    }
  // The borders of the shapes are about 500 pixels long and three pixels wide.
  EXPECT_LT(undecided, 2500);
}

TEST(TurnMask, EveryRayIsLookedUpInTheOlderMask) {
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0),
                                      Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, -2, 0.5)})
    for (const double degrees : {-15.0, 0.5, 8.0, 40.0}) expectTurned(turn(degrees, axis));
}

TEST(TurnMask, WithoutATurnTheMaskStays) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  EXPECT_EQ(cv::norm(turnMask(someMask(), camera, Eigen::Matrix3d::Identity()), someMask()), 0);
}

/// A camera that turns to the right (about its y axis, which points down) sees objects move to the
/// left by the focal length times the tangent of the angle.
TEST(TurnMask, ATurnToTheRightMovesTheMaskToTheLeft) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8U);
  const int v = static_cast<int>(camera.cy);
  cv::circle(mask, {static_cast<int>(camera.cx), v}, 3, cv::Scalar(255), cv::FILLED);
  const Eigen::Matrix3d R_then_now = turn(10, Eigen::Vector3d::UnitY());
  const cv::Mat turned = turnMask(mask, camera, R_then_now.transpose());
  const cv::Moments moments = cv::moments(turned, true);
  // The centre is rounded to a whole pixel twice.
  EXPECT_NEAR(moments.m10 / moments.m00, camera.cx - 250 * std::tan(10 * M_PI / 180), 1);
  EXPECT_NEAR(moments.m01 / moments.m00, v, 1);
}

TEST(TurnMask, OutsideTheOlderImageNothingIsMasked) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  const cv::Mat all(240, 320, CV_8U, cv::Scalar(255));
  // The image is 65 degrees wide. After a turn by 70 degrees the images have no ray in common.
  EXPECT_EQ(cv::countNonZero(turnMask(all, camera, turn(70, Eigen::Vector3d::UnitY()))), 0);
}

/// After half a turn every ray of the image pointed backwards in the older camera. The homography
/// alone does not tell backwards from forwards, and the mask would appear mirrored.
TEST(TurnMask, AfterHalfATurnNothingIsMasked) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  EXPECT_EQ(cv::countNonZero(turnMask(someMask(), camera, turn(180, Eigen::Vector3d::UnitY()))), 0);
}

}  // namespace
}  // namespace edge_mcl
