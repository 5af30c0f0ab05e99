#include "edge_mcl/core/drawing/trajectory_plot.h"

#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/drawing/chart.h"
#include "edge_mcl/core/drawing/text.h"

namespace edge_mcl {

namespace {

constexpr size_t kReference = 0, kEstimate = 1;  // numbers of the series, which set the colours

/// What is drawn against what: 0, 1, 2 for x, y, z and 3 for time.
struct Panel {
  int across, up;
  const char *title, *x_label, *y_label;
  cv::Rect area;
};

double coordinate(const StampedPose& p, int axis, double start) {
  return axis == 3 ? p.time - start : p.pose.translation()[axis];
}

void drawCurve(cv::Mat* picture, const Chart& chart, const Panel& panel, const Trajectory& poses,
               double start, size_t series) {
  constexpr size_t kFew = 80;  // poses that get a mark each
  const cv::Scalar colour = seriesColour(series);
  std::vector<cv::Point> pixels;
  pixels.reserve(poses.size());
  for (const StampedPose& p : poses)
    pixels.push_back(chart.at(coordinate(p, panel.across, start), coordinate(p, panel.up, start)));
  cv::polylines(*picture, pixels, false, colour, series == kReference ? 3 : 1, cv::LINE_AA);
  if (series == kEstimate && pixels.size() < kFew)
    for (const cv::Point& p : pixels) drawMark(picture, p, series, colour, 2);
}

void drawLegend(cv::Mat* picture, bool has_reference) {
  constexpr int kLine = 22, kHeight = 15;  // pixels
  int x = 60;
  for (const size_t series : {kEstimate, kReference}) {
    if (series == kReference && !has_reference) continue;
    const cv::Scalar colour = seriesColour(series);
    cv::line(*picture, {x, kLine - 5}, {x + 30, kLine - 5}, colour, series == kReference ? 3 : 1,
             cv::LINE_AA);
    x += 38;
    x += drawText(picture, series == kEstimate ? "estimate" : "reference", {x, kLine}, chartInk(),
                  kHeight);
    x += 30;
  }
}

}  // namespace

cv::Mat drawTrajectories(const Trajectory& estimate, const Trajectory& truth) {
  cv::Mat picture(890, 1180, CV_8UC3, cv::Scalar(255, 255, 255));
  const double start = estimate.empty() ? 0 : estimate.front().time;
  const Panel panels[] = {{0, 1, "from above", "x, m", "y, m", {0, 30, 590, 430}},
                          {0, 2, "from the side", "x, m", "z, m", {590, 30, 590, 430}},
                          {3, 0, "x over time", "s", "m", {0, 460, 393, 430}},
                          {3, 1, "y over time", "s", "m", {393, 460, 393, 430}},
                          {3, 2, "z over time", "s", "m", {786, 460, 393, 430}}};
  for (const Panel& panel : panels) {
    ChartAxis x(panel.x_label), y(panel.y_label);
    for (const Trajectory* list : {&truth, &estimate})
      for (const StampedPose& p : *list) {
        x.include(coordinate(p, panel.across, start));
        y.include(coordinate(p, panel.up, start));
      }
    x.close(0.06);
    y.close(0.06);
    const Chart chart(panel.area, panel.title, x, y, panel.across != 3);
    chart.drawFrame(&picture);
    drawCurve(&picture, chart, panel, truth, start, kReference);
    drawCurve(&picture, chart, panel, estimate, start, kEstimate);
  }
  drawLegend(&picture, !truth.empty());
  return picture;
}

}  // namespace edge_mcl
