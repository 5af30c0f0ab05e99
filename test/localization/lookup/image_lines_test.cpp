#include "edge_mcl/localization/lookup/image_lines.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/se3.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

constexpr int kWidth = 320, kHeight = 240;
constexpr double kFocal = 260;

/// A picture of a white rectangle on black.
EdgeImage rectangle(const cv::Rect& where, const cv::Mat& ignore = {}) {
  cv::Mat picture(kHeight, kWidth, CV_8U, cv::Scalar(20));
  cv::rectangle(picture, where, cv::Scalar(200), cv::FILLED);
  return findEdgesOf(picture, ignore, {});
}

TEST(ImageLines, AreTheSidesOfARectangle) {
  const CameraModel camera = test::pinhole(kWidth, kHeight, kFocal);
  const cv::Rect where(60, 50, 180, 120);
  const std::vector<ImageLine> lines = findImageLines(rectangle(where), camera);
  ASSERT_EQ(lines.size(), 4u);
  // The longest first: the upper and the lower side.
  const Eigen::Vector3d left((where.x - camera.cx) / kFocal, (where.y - camera.cy) / kFocal, 1),
      right((where.x + where.width - camera.cx) / kFocal, left.y(), 1);
  const double angle = std::acos(left.normalized().dot(right.normalized()));
  EXPECT_NEAR(lines[0].length, angle, 0.03);
  for (const ImageLine& line : lines) {
    EXPECT_NEAR(line.normal.norm(), 1, 1e-9);
    EXPECT_NEAR(line.normal.dot(line.start), 0, 1e-9);
    EXPECT_NEAR(line.normal.dot(line.end), 0, 1e-9);
  }
}

TEST(ImageLines, UnderTheMaskAreLeftOut) {
  const CameraModel camera = test::pinhole(kWidth, kHeight, kFocal);
  cv::Mat ignore(kHeight, kWidth, CV_8U, cv::Scalar(0));
  cv::rectangle(ignore, cv::Rect(40, 30, 40, 200), cv::Scalar(255), cv::FILLED);  // the left side
  EXPECT_EQ(findImageLines(rectangle(cv::Rect(60, 50, 180, 120), ignore), camera).size(), 3u);
}

/// Segments of a building with right angles, seen in a random orientation: of every axis some, and
/// some that are parallel to none.
class Orientation : public testing::Test {
 protected:
  std::vector<ImageLine> seenFrom(const Eigen::Matrix3d& R_building_camera, int clutter) {
    std::vector<ImageLine> lines;
    const auto add = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
      ImageLine line;
      line.start = a.normalized();
      line.end = b.normalized();
      const Eigen::Vector3d normal = line.start.cross(line.end);
      line.length = std::asin(normal.norm());
      line.normal = normal.normalized();
      lines.push_back(line);
    };
    const auto noise = [&] { return 0.002 * test::anywhere(&random_, -1, 1); };  // about a pixel
    for (int axis = 0; axis < 3; ++axis)
      for (int i = 0; i < 8; ++i) {
        // Two points of a line along the axis, in front of the camera.
        const Eigen::Vector3d p = test::anywhere(&random_, -1, 1) + Eigen::Vector3d(0, 0, 3);
        const Eigen::Vector3d along = R_building_camera.transpose() * Eigen::Vector3d::Unit(axis);
        add(p + 0.5 * along + noise(), p - 0.5 * along + noise());
      }
    for (int i = 0; i < clutter; ++i)
      add(test::anywhere(&random_, -1, 1) + Eigen::Vector3d(0, 0, 3),
          test::anywhere(&random_, -1, 1) + Eigen::Vector3d(0, 0, 3));
    return lines;
  }
  /// Smallest angle to the truth or to a quarter turn of it, degrees.
  static double errorOf(const Eigen::Matrix3d& R, const Eigen::Matrix3d& truth) {
    double least = 180;
    for (int quarter = 0; quarter < 4; ++quarter) {
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(quarter * M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      least = std::min(least, logSo3(R.transpose() * turn * truth).norm() / kDegree);
    }
    return least;
  }
  /// A camera that is held upright, up to some degrees.
  Eigen::Matrix3d anyRotation() {
    const Eigen::Vector3d tilt = test::anywhere(&random_, -0.25, 0.25);
    return Eigen::AngleAxisd(test::anywhere(&random_, -3, 3).x(), Eigen::Vector3d::UnitZ()) *
           opticalOnBody().linear() * expSo3(Eigen::Vector3d(tilt.x(), 0, tilt.z()));
  }
  test::Random random_{5};
};

TEST_F(Orientation, IsFoundWithAndWithoutGravity) {
  constexpr int kTrials = 60;
  constexpr double kRight = 2;  // degrees; the refinement corrects more
  int with = 0, without = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Eigen::Matrix3d truth = anyRotation();
    const std::vector<ImageLine> lines = seenFrom(truth, 12);
    KnownUp up;
    const auto best = [&](const std::vector<AxesRotation>& found) {
      return found.empty() ? 180 : errorOf(found.front().R_building_camera, truth);
    };
    without += best(rotationsOfAxes(lines, up, 3)) < kRight ? 1 : 0;
    up.up_camera = truth.row(2).transpose() + 0.02 * test::anywhere(&random_, -1, 1);
    up.sigma = 2 * kDegree;
    with += best(rotationsOfAxes(lines, up, 3)) < kRight ? 1 : 0;
  }
  // A third of the segments is clutter. By chance it agrees better with another orientation in a
  // tenth of the trials without gravity (6 of these 60).
  std::printf("with gravity %d, without %d of %d\n", with, without, kTrials);
  EXPECT_GE(with, 56);
  EXPECT_GE(without, 48);
}

TEST_F(Orientation, IsNoneWithoutSegments) { EXPECT_TRUE(rotationsOfAxes({}, {}, 3).empty()); }

}  // namespace
}  // namespace edge_mcl
