#include "edge_mcl/mapping/depth_segments.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace edge_mcl {
namespace {

CameraModel camera() {
  CameraModel c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 500;
  c.cx = 319.5;
  c.cy = 239.5;
  c.validate("test");
  return c;
}

/// A bright square of 1 m in the middle of the image, at the depth `square`, before a dark wall.
MappingImage squareBeforeWall(float square, float wall) {
  MappingImage image;
  image.grey = cv::Mat(480, 640, CV_8U, cv::Scalar(60));
  image.depth = cv::Mat(480, 640, CV_32F, cv::Scalar(wall));
  const int half = static_cast<int>(std::lround(250 / square));
  const cv::Rect area(320 - half, 240 - half, 2 * half, 2 * half);
  image.grey(area).setTo(180);
  image.depth(area).setTo(square);
  image.T_map_camera.translation() = Eigen::Vector3d(1, 2, 3);
  image.number = 7;
  return image;
}

/// Every side of the square is found at the depth of the square, also where a wall is behind it.
/// Half a pixel is 2 mm at 2 m.
TEST(DepthSegments, AreLiftedToTheNearerSurface) {
  for (const float wall : {2.0f, 3.0f}) {
    const MappingImage image = squareBeforeWall(2, wall);
    const auto segments = findDepthSegments(image, CameraRays(camera()), {});
    ASSERT_EQ(segments.size(), 4u) << wall;
    for (const DepthSegment& s : segments) {
      EXPECT_EQ(s.image, 7u);
      EXPECT_NEAR(s.length(), 1, 0.05);
      for (const Eigen::Vector3d& end : {s.start, s.end}) {
        const Eigen::Vector3d p = end - image.T_map_camera.translation();
        EXPECT_NEAR(p.z(), 2, 1e-3);
        EXPECT_NEAR(p.head<2>().cwiseAbs().maxCoeff(), 0.5, 0.005);
      }
      EXPECT_NEAR(s.ray_start.z(), 1, 1e-12);
      EXPECT_LT((image.T_map_camera * Eigen::Vector3d(2 * s.ray_start) - s.start).norm(), 2e-3);
    }
  }
}

TEST(DepthSegments, WithoutDepthNothingIsFound) {
  MappingImage image = squareBeforeWall(2, 2);
  image.depth.setTo(0);
  EXPECT_TRUE(findDepthSegments(image, CameraRays(camera()), {}).empty());
  image.depth.setTo(std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(findDepthSegments(image, CameraRays(camera()), {}).empty());
  image = squareBeforeWall(5, 5);  // beyond max_depth
  EXPECT_TRUE(findDepthSegments(image, CameraRays(camera()), {}).empty());
}

/// The border of a scan has depth on one side only.
TEST(DepthSegments, BothSidesMayBeNeeded) {
  const MappingImage image = squareBeforeWall(2, 0);
  SegmentOptions options;
  EXPECT_EQ(findDepthSegments(image, CameraRays(camera()), options).size(), 4u);
  options.needs_both_sides = true;
  EXPECT_TRUE(findDepthSegments(image, CameraRays(camera()), options).empty());
}

/// The image shows a straight line on a surface whose depth jumps to and fro.
TEST(DepthSegments, ALineOnARaggedSurfaceIsLeftOut) {
  MappingImage image = squareBeforeWall(2, 2);
  for (int y = 0; y < image.depth.rows; ++y)
    for (int x = 0; x < image.depth.cols; ++x)
      image.depth.at<float>(y, x) = 1.5f + 0.25f * static_cast<float>((x / 16 + y / 16) % 4);
  EXPECT_TRUE(findDepthSegments(image, CameraRays(camera()), {}).empty());
}

}  // namespace
}  // namespace edge_mcl
