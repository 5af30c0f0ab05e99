/// Stores the objects that a detector found in one image, and makes masks of them.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl {

/// One detected object.
struct Detection {
  int class_id = 0;   ///< number of the class in DetectorModel::classes
  float score = 0;    ///< 0 to 1
  cv::Rect2f box;     ///< pixels of the image
  cv::Mat mask;       ///< CV_8U of the image's size, 255 where the object is
  int track_id = -1;  ///< number of the track; -1: not tracked
  double age = 0;     ///< s since the network last saw it
};

using Detections = std::vector<Detection>;

/// Joins the masks of all objects. @param size of the image. @param dilation pixels by which every
/// object grows. @return CV_8U, 255 on an object, 0 elsewhere.
cv::Mat combinedMask(const Detections& detections, const cv::Size& size, int dilation);

/// Grows the non-zero area of a mask (CV_8U) by a disc with this radius in pixels.
void dilateMask(int pixels, cv::Mat* mask);

/// Intersection over union of two masks of equal size; 1 when both are empty.
double maskOverlap(const cv::Mat& a, const cv::Mat& b);

}  // namespace edge_mcl
