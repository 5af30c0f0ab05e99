#include "edge_mcl/detector/detections.h"

#include <opencv2/imgproc.hpp>

namespace edge_mcl {

namespace {
// px; for larger discs a distance transform is faster than the dilation.
constexpr int kLargestDisc = 32;
}  // namespace

void dilateMask(int pixels, cv::Mat* mask) {
  if (pixels <= 0) return;
  if (pixels > kLargestDisc) {
    cv::Mat distance;
    cv::distanceTransform(*mask == 0, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    *mask = distance <= pixels;
    return;
  }
  const cv::Mat disc =
      cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * pixels + 1, 2 * pixels + 1});
  cv::dilate(*mask, *mask, disc);
}

cv::Mat combinedMask(const Detections& detections, const cv::Size& size, int dilation) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8U);
  for (const Detection& d : detections) cv::bitwise_or(mask, d.mask, mask);
  if (!detections.empty()) dilateMask(dilation, &mask);
  return mask;
}

double maskOverlap(const cv::Mat& a, const cv::Mat& b) {
  const int either = cv::countNonZero(a | b);
  return either == 0 ? 1 : static_cast<double>(cv::countNonZero(a & b)) / either;
}

}  // namespace edge_mcl
