#include "edge_mcl/core/drawing/line_view.h"

#include <gtest/gtest.h>

#include "support/painted.h"

namespace edge_mcl {
namespace {

const cv::Scalar kRed(0, 0, 255), kBlue(255, 0, 0);

TEST(LineView, TheWholeBoxIsInThePicture) {
  const DrawnBox box{{0, 0, 0}, {10, 6, 3}};
  std::vector<DrawnLine> lines;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 3; ++k) {
      if (i >> k & 1) continue;
      const auto corner = [&](int n) {
        return Eigen::Vector3d(n & 1 ? 10 : 0, n & 2 ? 6 : 0, n & 4 ? 3 : 0);
      };
      lines.push_back({corner(i), corner(i | 1 << k), kRed});
    }
  const cv::Rect drawn =
      test::bounds(test::pixelsOf(drawLineView(lines, box, {}, {400, 300}), kRed, 60));
  EXPECT_GT(drawn.x, 2);
  EXPECT_GT(drawn.y, 2);
  EXPECT_LT(drawn.br().x, 398);
  EXPECT_LT(drawn.br().y, 298);
  EXPECT_GT(drawn.width, 200);
}

TEST(LineView, WhatIsHigherIsDrawnHigher) {
  const DrawnBox box{{0, 0, 0}, {2, 2, 2}};
  const cv::Mat picture = drawLineView(
      {{{0, 0, 0}, {2, 2, 0}, kRed}, {{0, 0, 2}, {2, 2, 2}, kBlue}}, box, {}, {300, 300});
  EXPECT_LT(test::bounds(test::pixelsOf(picture, kBlue, 60)).y,
            test::bounds(test::pixelsOf(picture, kRed, 60)).y);
}

TEST(LineView, ALegendEntryHasItsColour) {
  const cv::Mat picture = drawLineView({}, {{0, 0, 0}, {1, 1, 1}}, {{"walls", kRed}}, {300, 300});
  EXPECT_FALSE(test::bounds(test::pixelsOf(picture, kRed, 60)).empty());
}

}  // namespace
}  // namespace edge_mcl
