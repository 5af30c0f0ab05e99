// Tests how images of 16 bits become images of 8 bits.
#include "edge_mcl/core/image/eight_bits.h"

#include <gtest/gtest.h>

namespace edge_mcl {
namespace {

/// A grey ramp with values of up to `bits` bits.
cv::Mat ramp(int bits) {
  cv::Mat image(16, 256, CV_16U);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 256; ++x) image.at<uint16_t>(y, x) = static_cast<uint16_t>(x << (bits - 8));
  return image;
}

TEST(EightBits, TheBitsInUseDecide) {
  const cv::Mat expected = [] {
    cv::Mat eight;
    ramp(8).convertTo(eight, CV_8U);
    return eight;
  }();
  for (const int bits : {8, 10, 12, 14, 16})
    EXPECT_EQ(cv::norm(toEightBits(ramp(bits)), expected, cv::NORM_INF), 0) << bits;
}

/// A hot pixel does not darken the image.
TEST(EightBits, AFewBrightPixelsDoNotCount) {
  cv::Mat image = ramp(12);
  image.at<uint16_t>(3, 3) = 65535;
  const cv::Mat eight = toEightBits(image);
  EXPECT_EQ(eight.at<uint8_t>(3, 3), 255);
  EXPECT_EQ(eight.at<uint8_t>(0, 200), 200);
}

TEST(EightBits, ColoursAndEightBitsStay) {
  cv::Mat color;
  cv::merge(std::vector<cv::Mat>{ramp(12), ramp(12), ramp(12)}, color);
  EXPECT_EQ(toEightBits(color).type(), CV_8UC3);
  const cv::Mat eight(3, 3, CV_8U, cv::Scalar(7));
  EXPECT_EQ(toEightBits(eight).data, eight.data);
}

}  // namespace
}  // namespace edge_mcl
