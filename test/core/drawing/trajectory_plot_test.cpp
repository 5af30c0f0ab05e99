#include "edge_mcl/core/drawing/trajectory_plot.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/drawing/chart.h"
#include "support/painted.h"

namespace edge_mcl {
namespace {

/// The two charts above show the map, the three below show the coordinates over time.
struct Panels {
  cv::Rect from_above, from_the_side, over_time[3];
};

Panels panelsOf(const cv::Mat& picture) {
  const int half = picture.cols / 2, third = picture.cols / 3;
  constexpr int kLegend = 30, kUpper = 460;
  const int lower = picture.rows - kUpper;
  return {{0, kLegend, half, kUpper - kLegend},
          {half, kLegend, half, kUpper - kLegend},
          {{0, kUpper, third, lower},
           {third, kUpper, third, lower},
           {2 * third, kUpper, third, lower}}};
}

/// Area in which a panel has the colour of a series, relative to the panel. Lines are smoothed, so
/// their colour is blended with the paper.
cv::Rect curveIn(const cv::Mat& picture, const cv::Rect& panel, size_t series) {
  return test::bounds(test::pixelsOf(picture(panel), seriesColour(series), 60));
}
constexpr size_t kReference = 0, kEstimate = 1;

StampedPose poseAt(double time, double x, double y, double z) {
  StampedPose p;
  p.time = time;
  p.pose.translation() = Eigen::Vector3d(x, y, z);
  return p;
}

/// One turn on a circle of 2 m about (3, -1), at the height 1 m, with Unix time.
Trajectory circle() {
  Trajectory poses;
  for (int k = 0; k <= 200; ++k) {
    const double a = 2 * M_PI * k / 200;
    poses.push_back(poseAt(1305031102 + 0.1 * k, 3 + 2 * std::cos(a), -1 + 2 * std::sin(a), 1));
  }
  return poses;
}

TEST(TrajectoryPlot, ACircleIsACircleFromAboveAndALineFromTheSide) {
  const cv::Mat picture = drawTrajectories(circle(), {});
  ASSERT_EQ(picture.type(), CV_8UC3);
  const Panels panels = panelsOf(picture);
  const cv::Rect above = curveIn(picture, panels.from_above, kEstimate);
  EXPECT_GT(above.width, 150);
  EXPECT_NEAR(above.width, above.height, 3);
  const cv::Rect side = curveIn(picture, panels.from_the_side, kEstimate);
  EXPECT_GT(side.width, 150);
  EXPECT_LE(side.height, 4);
}

/// x and y swing once over the whole time, z does not change. The time starts at the first pose.
TEST(TrajectoryPlot, CoordinatesAreDrawnOverTime) {
  const cv::Mat picture = drawTrajectories(circle(), {});
  const Panels panels = panelsOf(picture);
  for (const cv::Rect& panel : panels.over_time) {
    const cv::Rect curve = curveIn(picture, panel, kEstimate);
    EXPECT_GT(curve.width, panel.width / 2);
    if (panel == panels.over_time[2])
      EXPECT_LE(curve.height, 4);
    else
      EXPECT_GT(curve.height, panel.height / 2);
  }
}

TEST(TrajectoryPlot, WithoutAReferenceItsColourDoesNotAppear) {
  const cv::Mat alone = drawTrajectories(circle(), {}), both = drawTrajectories(circle(), circle());
  EXPECT_EQ(cv::countNonZero(test::pixelsOf(alone, seriesColour(kReference))), 0);
  for (const cv::Mat& picture : {alone, both}) {
    // The legend is above the charts.
    const cv::Rect legend(0, 0, picture.cols, 30);
    EXPECT_FALSE(curveIn(picture, legend, kEstimate).empty());
    EXPECT_EQ(curveIn(picture, legend, kReference).empty(), picture.data == alone.data);
  }
}

/// Both trajectories have the same axes. The reference is 1 m farther along y and along z, so it is
/// higher in the picture, and it is not shifted along x.
TEST(TrajectoryPlot, EstimateAndReferenceShareTheirAxes) {
  Trajectory estimate, reference;
  for (int k = 0; k <= 100; ++k) {
    estimate.push_back(poseAt(k, 0.1 * k, 0, 0));
    reference.push_back(poseAt(k, 0.1 * k, 1, 1));
  }
  const cv::Mat picture = drawTrajectories(estimate, reference);
  const Panels panels = panelsOf(picture);
  for (const cv::Rect& panel :
       {panels.from_above, panels.from_the_side, panels.over_time[1], panels.over_time[2]}) {
    const cv::Rect lower = curveIn(picture, panel, kEstimate);
    const cv::Rect upper = curveIn(picture, panel, kReference);
    EXPECT_LT(upper.br().y, lower.y);
    EXPECT_NEAR(upper.x, lower.x, 3);  // the reference is drawn with a broader line
    EXPECT_NEAR(upper.br().x, lower.br().x, 3);
  }
}

/// A curve of one pose has no length. Its mark shows it.
TEST(TrajectoryPlot, AFewPosesHaveMarks) {
  const cv::Mat picture = drawTrajectories({poseAt(5, 1, 2, 3)}, {});
  const Panels panels = panelsOf(picture);
  for (const cv::Rect& panel : {panels.from_above, panels.from_the_side, panels.over_time[0],
                                panels.over_time[1], panels.over_time[2]}) {
    const cv::Rect mark = curveIn(picture, panel, kEstimate);
    EXPECT_GE(mark.width, 3);
    EXPECT_LE(mark.width, 9);
  }
}

TEST(TrajectoryPlot, WithoutPosesTheChartsAreEmpty) {
  const cv::Mat picture = drawTrajectories({}, {});
  EXPECT_GT(cv::countNonZero(test::paintedPixels(picture)), 1000);  // frames and labels
  EXPECT_TRUE(curveIn(picture, panelsOf(picture).from_above, kEstimate).empty());
  EXPECT_EQ(drawTrajectories({}, circle()).size(), picture.size());
}

}  // namespace
}  // namespace edge_mcl
