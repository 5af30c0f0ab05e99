#include "edge_mcl/detector/detection_overlay.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/drawing/text.h"

namespace edge_mcl {

cv::Scalar colorOfClass(int class_id) {
  // Okabe and Ito's palette without black.
  static const cv::Scalar kColors[] = {{0, 159, 230},  {233, 180, 86}, {115, 158, 0},
                                       {66, 228, 240}, {178, 114, 0},  {0, 94, 213},
                                       {167, 121, 204}};
  return kColors[static_cast<size_t>(class_id < 0 ? 0 : class_id) % std::size(kColors)];
}

cv::Mat drawDetections(const cv::Mat& image, const Detections& detections,
                       const std::vector<std::string>& classes) {
  cv::Mat picture;
  if (image.channels() == 1)
    cv::cvtColor(image, picture, cv::COLOR_GRAY2BGR);
  else
    picture = image.clone();
  const int height = std::max(12, picture.cols / 30);  // of the text, pixels
  for (const Detection& d : detections) {
    const cv::Scalar color = colorOfClass(d.class_id);
    cv::Mat tinted(picture.size(), CV_8UC3, color);
    cv::addWeighted(picture, 0.55, tinted, 0.45, 0, tinted);
    tinted.copyTo(picture, d.mask);
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(d.mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    for (const auto& outline : outlines)
      for (size_t i = 0; i < outline.size(); ++i)
        if (d.age <= 0 || i / 6 % 2 == 0)
          cv::circle(picture, outline[i], picture.cols > 500 ? 1 : 0, color, -1);
  }
  for (const Detection& d : detections) {  // names last, so that no tint covers them
    const bool known = d.class_id >= 0 && d.class_id < static_cast<int>(classes.size());
    char text[96];
    std::string name = known ? classes[static_cast<size_t>(d.class_id)] : "?";
    if (d.track_id >= 0) name += " #" + std::to_string(d.track_id);
    std::snprintf(text, sizeof text, "%s %.2f", name.c_str(), static_cast<double>(d.score));
    const cv::Size size = textSize(text, height);
    const int x = std::max(0, std::min(cvRound(d.box.x), picture.cols - size.width - 2));
    const int y = std::max(size.height + 3, cvRound(d.box.y));
    cv::rectangle(picture, {x, y - size.height - 3}, {x + size.width + 3, y + 2},
                  colorOfClass(d.class_id), -1);
    drawText(&picture, text, {x + 2, y - 1}, {0, 0, 0}, height);
  }
  return picture;
}

}  // namespace edge_mcl
