#include "edge_mcl/core/drawing/line_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/drawing/chart.h"
#include "edge_mcl/core/drawing/text.h"

namespace edge_mcl {

namespace {

/// Direction to the eye: above one corner.
Eigen::Vector3d backwards() { return Eigen::Vector3d(-0.6, -0.9, 0.65).normalized(); }

}  // namespace

double DrawnBox::radius() const { return std::max(1e-6, (highest - lowest).norm() / 2); }

Eigen::Vector3d DrawnBox::eye() const {
  // Far enough away to see the whole box.
  return (lowest + highest) / 2 + 3.2 * radius() * backwards();
}

cv::Mat drawLineView(const std::vector<DrawnLine>& lines, const DrawnBox& box,
                     const std::vector<LegendEntry>& legend, cv::Size size) {
  const cv::Scalar paper(255, 255, 255);
  cv::Mat picture(size, CV_8UC3, paper);
  Pose view = Pose::Identity();
  view.linear().col(2) = -backwards();
  view.linear().col(0) = (-backwards()).cross(Eigen::Vector3d::UnitZ()).normalized();
  view.linear().col(1) = view.linear().col(2).cross(view.linear().col(0));
  view.translation() = box.eye();
  const Pose view_from_map = view.inverse();
  const double focal = 1.45 * std::min(size.width, size.height);
  const auto project = [&](const Eigen::Vector3d& p) {
    const Eigen::Vector3d q = view_from_map * p;
    return cv::Point(static_cast<int>(std::lround(size.width / 2.0 + focal * q.x() / q.z())),
                     static_cast<int>(std::lround(size.height / 2.0 + focal * q.y() / q.z())));
  };
  for (const DrawnLine& line : lines)
    cv::line(picture, project(line.start), project(line.end), line.colour, line.width, cv::LINE_AA);
  int y = 22;
  for (const LegendEntry& entry : legend) {
    cv::line(picture, {12, y - 4}, {40, y - 4}, entry.colour, 2, cv::LINE_AA);
    drawText(&picture, entry.text, {48, y}, chartInk(), kChartText);
    y += 20;
  }
  std::array<char, 96> text{};
  const Eigen::Vector3d extent = box.highest - box.lowest;
  std::snprintf(text.data(), text.size(), "%.3g x %.3g x %.3g m", extent.x(), extent.y(),
                extent.z());
  drawText(&picture, text.data(), {12, size.height - 12}, chartInk(), kChartText);
  return picture;
}

}  // namespace edge_mcl
