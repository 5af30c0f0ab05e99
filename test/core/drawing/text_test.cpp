#include "edge_mcl/core/drawing/text.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "support/painted.h"

namespace edge_mcl {
namespace {

const cv::Scalar kInk(60, 60, 60);

/// A white picture with a text at (200, 100).
cv::Mat pictureOf(const std::string& text, int height, TextAnchor anchor = TextAnchor::kLeft) {
  cv::Mat picture = test::whitePaper(400, 200);
  drawText(&picture, text, {200, 100}, kInk, height, anchor);
  return picture;
}

TEST(DrawText, ReturnsTheWidthOfTheText) {
  for (const int height : {10, 13, 20, 40})
    for (const char* text : {"x", "12.5", "from above"}) {
      cv::Mat picture = test::whitePaper(400, 200);
      EXPECT_EQ(drawText(&picture, text, {10, 100}, kInk, height), textSize(text, height).width);
      // Letters have spaces beside them, of up to a tenth of the height on either side.
      const cv::Rect ink = test::bounds(test::paintedPixels(picture));
      EXPECT_NEAR(ink.width, textSize(text, height).width, 3 + height / 5.0) << text;
    }
}

/// The anchor says which part of the text lies at the point. Spaces beside letters are at most a
/// few pixels wide.
TEST(DrawText, TheAnchorIsAtThePoint) {
  const auto inkOf = [](TextAnchor anchor) {
    return test::bounds(test::paintedPixels(pictureOf("HHHHHH", 20, anchor)));
  };
  const cv::Rect left = inkOf(TextAnchor::kLeft), right = inkOf(TextAnchor::kRight);
  const cv::Rect centre = inkOf(TextAnchor::kCentre);
  EXPECT_NEAR(left.x, 200, 5);
  EXPECT_NEAR(right.br().x, 200, 5);
  EXPECT_NEAR(centre.x + centre.width / 2.0, 200, 5);
  EXPECT_EQ(left.y, right.y);
  EXPECT_EQ(left.size(), centre.size());
}

/// Capital letters stand on the base line, and are some 70 % as high as the font. Smoothing may add
/// two pixels above and two below, which matters at small sizes.
TEST(DrawText, CapitalsStandOnTheBaseLine) {
  for (const int height : {14, 20, 40, 60}) {
    const cv::Rect ink = test::bounds(test::paintedPixels(pictureOf("HEL", height)));
    EXPECT_NEAR(ink.br().y, 100, 3) << height;
    EXPECT_NEAR(ink.height, 0.7 * height, 4 + 0.05 * height) << height;
    EXPECT_NEAR(textSize("HEL", height).height, ink.height, 4 + 0.05 * height) << height;
  }
}

TEST(DrawText, ALongerTextIsWider) {
  EXPECT_LT(textSize("12", 13).width, textSize("1234", 13).width);
  EXPECT_LT(textSize("text", 13).width, textSize("text", 26).width);
}

TEST(DrawText, AnEmptyTextPaintsNothing) {
  cv::Mat picture = test::whitePaper(40, 20);
  EXPECT_EQ(drawText(&picture, "", {5, 15}, kInk, 13), 0);
  EXPECT_EQ(cv::countNonZero(test::paintedPixels(picture)), 0);
}

/// The ink has the given colour, blended with the paper at the borders of strokes.
TEST(DrawText, HasItsColour) {
  cv::Mat picture = test::whitePaper(200, 100);
  drawText(&picture, "HHH", {10, 80}, cv::Scalar(0, 0, 255), 60);
  cv::Mat reddish;
  cv::inRange(picture, cv::Scalar(0, 0, 255), cv::Scalar(120, 120, 255), reddish);
  EXPECT_GT(cv::countNonZero(reddish), 20);
  std::vector<cv::Mat> channels;
  cv::split(picture, channels);
  EXPECT_EQ(cv::countNonZero(channels[2] != 255), 0) << "paper and ink have full red";
}

/// A text that does not fit is cut off at the border of the picture.
TEST(DrawText, MayLeaveThePicture) {
  cv::Mat picture = test::whitePaper(60, 30);
  EXPECT_NO_THROW(drawText(&picture, "a long text", {30, 20}, kInk, 20));
  EXPECT_NO_THROW(drawText(&picture, "a long text", {-30, 5}, kInk, 20));
  EXPECT_NO_THROW(drawText(&picture, "a long text", {300, 200}, kInk, 20));
  EXPECT_GT(cv::countNonZero(test::paintedPixels(picture)), 0);
}

/// Many threads draw at once, and all pictures are equal to the one that is drawn alone.
TEST(DrawText, MayBeCalledFromManyThreads) {
  const std::string text = "0123456789 threads";
  const cv::Mat alone = pictureOf(text, 17);
  std::vector<cv::Mat> pictures(4 * 20);
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (size_t i = 0; i < 20; ++i) pictures[20 * t + i] = pictureOf(text, 17);
    });
  for (auto& thread : threads) thread.join();
  for (const cv::Mat& picture : pictures) EXPECT_EQ(cv::norm(picture, alone, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace edge_mcl
