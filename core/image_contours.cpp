#include "edge_mcl/core/image_contours.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edge_mcl {

namespace {

constexpr int kDirections = 8;

/// Number of the bin of a line's direction, of half a turn.
int binOf(double dx, double dy) {
  double angle = std::atan2(dy, dx) / M_PI;  // half a turn is 1
  angle -= std::floor(angle);
  return static_cast<int>(angle * kDirections) % kDirections;
}

uint8_t bit(int bin) { return static_cast<uint8_t>(1U << ((bin + kDirections) % kDirections)); }

}  // namespace

ImageContours::ImageContours(const EdgeImage& image) {
  cell_ = std::max(1, image.width() / 160);
  columns_ = (image.width() + cell_ - 1) / cell_;
  rows_ = (image.height() + cell_ - 1) / cell_;
  cv::Mat labels, statistics, centroids;
  cv::connectedComponentsWithStats(image.edges, labels, statistics, centroids, 8, CV_32S);
  // Noise makes edges of some twenty pixels, whatever the image's size, and they curl up.
  const int extent = std::max(32, image.width() / 20);
  std::vector<bool> is_long(static_cast<size_t>(statistics.rows), false);
  for (int k = 1; k < statistics.rows; ++k)
    is_long[static_cast<size_t>(k)] =
        std::max(statistics.at<int32_t>(k, cv::CC_STAT_WIDTH),
                 statistics.at<int32_t>(k, cv::CC_STAT_HEIGHT)) >= extent;
  for (int y = 0; y < image.height(); ++y) {
    const auto* row = labels.ptr<int32_t>(y);
    for (int x = 0; x < image.width(); ++x) {
      if (!is_long[static_cast<size_t>(row[x])]) continue;
      const Eigen::Vector2d normal = image.normalAt(x, y);
      if (normal.isZero()) continue;
      pixels_.push_back({static_cast<uint32_t>(y / cell_ * columns_ + x / cell_),
                         bit(binOf(-normal.y(), normal.x()))});
    }
  }
}

size_t ImageContours::explainedBy(const VisibleSet& visible, const CameraModel& camera,
                                  const Pose& T_map_camera, double sample_step) const {
  // A margin of one cell around the image, so that neighbours need no checks.
  const int stride = columns_ + 2;
  std::vector<uint8_t> painted(static_cast<size_t>(stride) * (rows_ + 2), 0);
  const auto paint = [&](const Eigen::Vector2d& p, uint8_t directions) {
    const int column = static_cast<int>(std::floor((p.x() + 0.5) / cell_)) + 1;
    const int row = static_cast<int>(std::floor((p.y() + 0.5) / cell_)) + 1;
    if (column < 1 || row < 1 || column > columns_ || row > rows_) return;
    for (int r = row - 1; r <= row + 1; ++r)
      for (int c = column - 1; c <= column + 1; ++c)
        painted[static_cast<size_t>(r * stride + c)] |= directions;
  };
  const Pose camera_from_map = T_map_camera.inverse();
  for (const VisibleSet::Segment& segment : visible.segments) {
    const Eigen::Vector3d along =
        sample_step / 2 *
        (camera_from_map.linear() * visible.line(segment).tangent().cast<double>());
    for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i) {
      if (!(segment.samples >> i & 1U)) continue;
      const Eigen::Vector3d p =
          camera_from_map * visible.model->samplePosition(visible.edgeSegment(segment), i);
      Eigen::Vector2d centre, from, to;
      if (!camera.project(p, &centre) || !camera.contains(centre)) continue;
      if (!camera.project(p - along, &from)) from = centre;
      if (!camera.project(p + along, &to)) to = centre;
      const Eigen::Vector2d way = to - from;
      if (way.squaredNorm() < 1e-12) continue;
      const int bin = binOf(way.x(), way.y());
      const auto directions = static_cast<uint8_t>(bit(bin - 1) | bit(bin) | bit(bin + 1));
      // Seen nearly end-on from close by, a piece may be long in the image.
      const int steps =
          std::clamp(static_cast<int>(way.norm() / cell_) + 1, 1, 2 * (columns_ + rows_));
      for (int k = 0; k <= steps; ++k)
        paint(from + way * (static_cast<double>(k) / steps), directions);
    }
  }
  size_t explained = 0;
  for (const Pixel& pixel : pixels_) {
    const auto row = static_cast<int>(pixel.cell) / columns_;
    const auto column = static_cast<int>(pixel.cell) % columns_;
    explained +=
        (painted[static_cast<size_t>((row + 1) * stride + column + 1)] & pixel.direction) != 0;
  }
  return explained;
}

}  // namespace edge_mcl
