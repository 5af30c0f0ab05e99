/// Charts: axes with ticks, curves, marks.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace edge_mcl {

/// The range of one axis. Include values first, then draw.
class ChartAxis {
 public:
  explicit ChartAxis(std::string label, bool logarithmic = false)
      : label_(std::move(label)), logarithmic_(logarithmic) {}

  /// Extends the range. Values of a logarithmic axis are at least 1e-4.
  void include(double value);
  /// Widens the range by a share on both sides, and to full powers of ten on a logarithmic axis.
  void close(double margin = 0);
  /// 0 at the low end of the axis, 1 at the high end. @pre close() was called
  double at(double value) const;
  /// Round values for labels.
  std::vector<double> ticks() const;
  /// Length of the range in units of the axis; powers of ten on a logarithmic one.
  double span() const { return high_ - low_; }
  /// Enlarges the range about its middle.
  void setSpan(double span);
  const std::string& label() const { return label_; }

 private:
  double scaled(double value) const;
  std::string label_;
  bool logarithmic_;
  double low_ = 1e300, high_ = -1e300;
};

/// One chart in an area of a picture.
class Chart {
 public:
  /// @param area pixels of the chart with all of its labels
  /// @param equal_scale a unit has the same length on both axes, as on a map
  Chart(cv::Rect area, std::string title, ChartAxis x, ChartAxis y, bool equal_scale = false);

  void drawFrame(cv::Mat* picture) const;
  cv::Point at(double x, double y) const;
  /// Area within the axes, pixels.
  const cv::Rect& inner() const { return inner_; }

 private:
  cv::Rect area_, inner_;
  std::string title_;
  ChartAxis x_, y_;
};

/// Colours of Okabe and Ito, which readers with colour blindness can tell apart. There are eight.
cv::Scalar seriesColour(size_t series);
/// Draws a mark whose shape belongs to the series: circle, square, triangle, diamond, cross, plus,
/// star, triangle downwards, ring. Series have different shapes as well as different colours.
void drawMark(cv::Mat* picture, cv::Point centre, size_t series, const cv::Scalar& colour,
              int radius = 5);

/// Dark grey for text and light grey for grids.
inline cv::Scalar chartInk() { return {60, 60, 60}; }
inline cv::Scalar chartGrid() { return {228, 228, 228}; }
/// Height of the text in charts, pixels.
constexpr int kChartText = 13, kChartTitle = 16;

}  // namespace edge_mcl
