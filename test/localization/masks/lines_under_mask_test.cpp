#include "edge_mcl/localization/masks/lines_under_mask.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/image/image_edges.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// The map holds a square of 1 m, 2 m in front of a camera that looks along z. In the image the
/// square lies between columns 98 and 222 and rows 58 and 182. A mask covers the square and its
/// surroundings.
class MaskOverASquare : public testing::Test {
 protected:
  static MeshModel square() {
    MeshSoup soup;
    soup.vertices = {{-0.5F, -0.5F, 2}, {0.5F, -0.5F, 2}, {0.5F, 0.5F, 2}, {-0.5F, 0.5F, 2}};
    for (uint32_t i = 0; i < 4; ++i) soup.lines.push_back({i, (i + 1) % 4});
    return weldMesh(std::move(soup), 1e-6, "square");
  }
  static cv::Mat background() { return {240, 320, CV_8U, cv::Scalar(80)}; }
  static cv::Mat withSquare() {
    cv::Mat grey = background();
    cv::rectangle(grey, {98, 58}, {221, 181}, cv::Scalar(180), cv::FILLED);
    return grey;
  }
  static CameraModel camera() {
    CameraModel camera = test::pinhole(320, 240, 250);
    camera.fy = camera.fx;
    camera.cy = 119.5;
    return camera;
  }
  std::vector<LineUnderMask> linesIn(const cv::Mat& grey, double x = 0) const {
    Pose pose = Pose::Identity();
    pose.translation().x() = x;
    return linesUnderMask(mask_, EdgePixels(findEdges(grey, {}, {}, "image")),
                          visibility_.exact(pose.translation()), camera_, pose, edges_.sample_step,
                          {});
  }
  static bool isUpright(const LineUnderMask& line) {
    const auto& [from, to] = line.pieces.front();
    return std::abs(from.y() - to.y()) > std::abs(from.x() - to.x());
  }

  const CameraModel camera_ = camera();
  MeshModel mesh_ = square();
  const EdgeModel edges_ = buildEdgeModel(&mesh_, {});
  const Visibility visibility_{mesh_, edges_, {}};
  cv::Mat mask_ = [] {
    cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
    mask(cv::Rect(60, 30, 200, 190)) = 255;
    return mask;
  }();
};

TEST_F(MaskOverASquare, AllOfWhatTheMapHoldsIsShown) {
  const std::vector<LineUnderMask> lines = linesIn(withSquare());
  ASSERT_EQ(lines.size(), 4u);
  for (const LineUnderMask& line : lines) {
    EXPECT_NEAR(line.length, 125, 1);
    // At the corners the gradient has no direction, so some pixels are not shown.
    EXPECT_GT(line.shown, 0.9 * line.length);
  }
}

TEST_F(MaskOverASquare, NothingIsShownOfWhatIsNotThere) {
  for (const LineUnderMask& line : linesIn(background())) EXPECT_EQ(line.shown, 0);
  // A disc in front of the square touches each side where its outline is parallel to the side. The
  // outline of a circle of 62 pixels radius stays within 4 pixels of its tangent for 2 * sqrt(2 *
  // 62 * 4) = 45 pixels.
  cv::Mat disc = background();
  cv::circle(disc, {160, 120}, 62, cv::Scalar(180), cv::FILLED);
  for (const LineUnderMask& line : linesIn(disc)) EXPECT_LT(line.shown, 50);
}

TEST_F(MaskOverASquare, AtAWrongPoseOnlyWhatRunsAlongTheErrorIsShown) {
  // 10 cm are 12 pixels. So the upright sides are not shown, and the level sides are shown except
  // for these pixels.
  for (const LineUnderMask& line : linesIn(withSquare(), 0.1)) {
    if (isUpright(line)) {
      EXPECT_EQ(line.shown, 0);
    } else {
      EXPECT_NEAR(line.shown, 125 - 12.5, 6);
    }
  }
}

TEST_F(MaskOverASquare, WhoStandsBeforeItHidesIt) {
  // A dark object covers the left half, and a margin in which its contour bends.
  cv::Mat grey = withSquare();
  cv::rectangle(grey, {66, 40}, {160, 200}, cv::Scalar(30), cv::FILLED);
  for (const LineUnderMask& line : linesIn(grey)) {
    const bool left = isUpright(line) && line.pieces.front().from.x() < 160;
    EXPECT_NEAR(line.shown, left ? 0 : isUpright(line) ? 125 : 62, 10);
  }
}

/// The mask has a gap of 20 columns in its middle. So each level side gives two lines.
TEST_F(MaskOverASquare, PartsOfTheMaskAreLookedAtOneByOne) {
  mask_.colRange(150, 170) = 0;
  int level = 0;
  for (const LineUnderMask& line : linesIn(withSquare())) {
    if (isUpright(line)) continue;
    ++level;
    EXPECT_NEAR(line.length, 52, 3);
  }
  EXPECT_EQ(level, 4);
}

TEST_F(MaskOverASquare, TheBandOfALineIsCleared) {
  cv::Mat mask = mask_.clone();
  for (const LineUnderMask& line : linesIn(withSquare())) clearAlong(line, 8, &mask);
  // The mask is cleared eight pixels to either side of all four sides, and nowhere else.
  for (const int y : {58 - 7, 58, 58 + 7, 182 - 7, 182, 182 + 7})
    EXPECT_EQ(cv::countNonZero(mask.row(y).colRange(100, 220)), 0) << y;
  for (const int x : {98 - 7, 98, 98 + 7, 222 - 7, 222, 222 + 7})
    EXPECT_EQ(cv::countNonZero(mask.col(x).rowRange(60, 180)), 0) << x;
  EXPECT_EQ(cv::countNonZero(mask.row(120).colRange(112, 208)), 208 - 112);
  EXPECT_EQ(cv::countNonZero(mask.row(32).colRange(60, 260)), 200);
}

}  // namespace
}  // namespace edge_mcl
