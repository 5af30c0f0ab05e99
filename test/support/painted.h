/// Where something was painted on white paper.
#pragma once

#include <algorithm>
#include <opencv2/core.hpp>

namespace edge_mcl::test {

inline cv::Mat whitePaper(int width, int height) {
  return {height, width, CV_8UC3, cv::Scalar(255, 255, 255)};
}

/// 255 at pixels that are not white.
inline cv::Mat paintedPixels(const cv::Mat& picture) {
  cv::Mat white;
  cv::inRange(picture, cv::Scalar(255, 255, 255), cv::Scalar(255, 255, 255), white);
  return 255 - white;
}

/// 255 at pixels of about this colour (blue, green, red). @param tolerance per channel
inline cv::Mat pixelsOf(const cv::Mat& picture, const cv::Scalar& colour, double tolerance = 0) {
  cv::Mat same;
  cv::inRange(picture, colour - cv::Scalar::all(tolerance), colour + cv::Scalar::all(tolerance),
              same);
  return same;
}

/// Smallest rectangle around all pixels that are not 0; empty when there are none.
inline cv::Rect bounds(const cv::Mat& pixels) {
  int left = pixels.cols, top = pixels.rows, right = -1, bottom = -1;
  for (int y = 0; y < pixels.rows; ++y)
    for (int x = 0; x < pixels.cols; ++x) {
      if (!pixels.at<uint8_t>(y, x)) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  return right < 0 ? cv::Rect() : cv::Rect(left, top, right - left + 1, bottom - top + 1);
}

}  // namespace edge_mcl::test
