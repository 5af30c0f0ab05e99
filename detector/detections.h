/// What a detector found in one image.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl {

/// One object.
struct Detection {
  int class_id = 0;
  float score = 0;    ///< 0 to 1
  cv::Rect2f box;     ///< pixels of the image
  cv::Mat mask;       ///< CV_8U of the image's size, 255 where the object is
  int track_id = -1;  ///< -1: not tracked
  double age = 0;     ///< s since the network last saw it
};

using Detections = std::vector<Detection>;

/// All masks in one: CV_8U, 255 where something is that is not in the map, all zero when there is
/// nothing. @param dilation pixels by which every object grows.
cv::Mat combinedMask(const Detections& detections, const cv::Size& size, int dilation);

/// Grows what is not zero by so many pixels, round.
void dilateMask(int pixels, cv::Mat* mask);

/// Share of the pixels of either mask that are in both; 1 when both are empty.
double maskOverlap(const cv::Mat& a, const cv::Mat& b);

}  // namespace edge_mcl
