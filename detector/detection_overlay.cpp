#include "edge_mcl/detector/detection_overlay.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>

namespace edge_mcl {

cv::Scalar colorOfClass(int class_id) {
  // Okabe and Ito's palette without black and yellow's neighbour.
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
  const double scale = std::max(0.35, picture.cols / 900.0);
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
  for (const Detection& d : detections) {  // names above all tints
    const bool known = d.class_id >= 0 && d.class_id < static_cast<int>(classes.size());
    char text[96];
    std::string name = known ? classes[static_cast<size_t>(d.class_id)] : "?";
    if (d.track_id >= 0) name += " #" + std::to_string(d.track_id);
    std::snprintf(text, sizeof text, "%s %.2f", name.c_str(), static_cast<double>(d.score));
    int base = 0;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, 1, &base);
    const int x = std::max(0, std::min(cvRound(d.box.x), picture.cols - size.width - 2));
    const int y = std::max(size.height + 3, cvRound(d.box.y));
    cv::rectangle(picture, {x, y - size.height - 3}, {x + size.width + 3, y + 2},
                  colorOfClass(d.class_id), -1);
    cv::putText(picture, text, {x + 2, y - 1}, cv::FONT_HERSHEY_SIMPLEX, scale, {0, 0, 0}, 1,
                cv::LINE_AA);
  }
  return picture;
}

}  // namespace edge_mcl
