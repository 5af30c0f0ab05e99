/// Draws lines in space as seen from above one corner of them.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl {

struct DrawnLine {
  Eigen::Vector3d start, end;  ///< metres
  cv::Scalar colour;           ///< blue, green, red
  int width = 1;               ///< pixels
};

struct LegendEntry {
  std::string text;
  cv::Scalar colour;
};

/// Corners of the box that the picture shows, metres.
struct DrawnBox {
  Eigen::Vector3d lowest, highest;

  double radius() const;
  /// Place from which the picture is taken.
  Eigen::Vector3d eye() const;
};

/// Draws the lines in perspective, in their order, with the legend and the size of the box.
cv::Mat drawLineView(const std::vector<DrawnLine>& lines, const DrawnBox& box,
                     const std::vector<LegendEntry>& legend, cv::Size size);

}  // namespace edge_mcl
