#include "edge_mcl/localization/search/image_contours.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace edge_mcl {

namespace {

constexpr int kDirections = 8;

/// Number of the direction bin of an undirected line. The bins share half a turn.
int binOf(double dx, double dy) {
  double angle = std::atan2(dy, dx) / M_PI;  // half a turn is 1
  angle -= std::floor(angle);
  return static_cast<int>(angle * kDirections) % kDirections;
}

uint8_t bit(int bin) { return static_cast<uint8_t>(1U << ((bin + kDirections) % kDirections)); }

/// Bits of a direction bin and of its two neighbours.
uint8_t around(int bin) { return bit(bin - 1) | bit(bin) | bit(bin + 1); }

}  // namespace

ImageContours::ImageContours(const EdgeImage& image) {
  cell_ = std::max(1, image.width() / 160);
  columns_ = (image.width() + cell_ - 1) / cell_;
  rows_ = (image.height() + cell_ - 1) / cell_;
  stride_ = static_cast<size_t>(columns_) + 2;
  paintEdges(image);
  cv::Mat labels, statistics, centroids;
  cv::connectedComponentsWithStats(image.edges, labels, statistics, centroids, 8, CV_32S);
  // Edges from noise are about twenty pixels long, independent of the image's size, and they curl
  // up.
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
      pixels_.push_back({static_cast<uint32_t>(cellAt(x, y)), bit(binOf(-normal.y(), normal.x()))});
    }
  }
}

size_t ImageContours::cellAt(int x, int y) const {
  return static_cast<size_t>(y / cell_ + 1) * stride_ + static_cast<size_t>(x / cell_ + 1);
}

void ImageContours::paintAround(size_t cell, uint8_t directions, Cells* cells) const {
  for (size_t row = cell - stride_; row <= cell + stride_; row += stride_)
    for (size_t c = row - 1; c <= row + 1; ++c) (*cells)[c] |= directions;
}

void ImageContours::paintEdges(const EdgeImage& image) {
  constexpr uint8_t kAll = 255;
  image_edges_.assign(stride_ * static_cast<size_t>(rows_ + 2), 0);
  for (int y = 0; y < image.height(); ++y) {
    const auto* edges = image.edges.ptr<uint8_t>(y);
    const auto* ignore = image.ignore.empty() ? nullptr : image.ignore.ptr<uint8_t>(y);
    for (int x = 0; x < image.width(); ++x) {
      if (ignore && ignore[x]) {
        paintAround(cellAt(x, y), kAll, &image_edges_);
      } else if (edges[x]) {
        const Eigen::Vector2d normal = image.normalAt(x, y);
        if (!normal.isZero())
          paintAround(cellAt(x, y), around(binOf(-normal.y(), normal.x())), &image_edges_);
      }
    }
  }
}

ContourMatch ImageContours::compare(const VisibleSet& visible, const CameraModel& camera,
                                    const Pose& T_map_camera, double sample_step) const {
  Cells near_model(image_edges_.size(), 0), on_model(image_edges_.size(), 0);
  const auto paint = [&](const Eigen::Vector2d& p, int bin) {
    const double x = std::floor((p.x() + 0.5) / cell_), y = std::floor((p.y() + 0.5) / cell_);
    if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return;
    const size_t cell = (static_cast<size_t>(y) + 1) * stride_ + static_cast<size_t>(x) + 1;
    paintAround(cell, around(bin), &near_model);
    on_model[cell] |= bit(bin);
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
      // A piece that is seen nearly end-on from close by may be very long in the image.
      const int steps =
          std::clamp(static_cast<int>(way.norm() / cell_) + 1, 1, 2 * (columns_ + rows_));
      for (int k = 0; k <= steps; ++k) paint(from + way * (static_cast<double>(k) / steps), bin);
    }
  }
  ContourMatch match;
  for (const Pixel& pixel : pixels_)
    match.explained += (near_model[pixel.cell] & pixel.direction) != 0;
  // A line crosses a cell in about as many pixels as the side of the cell has.
  for (size_t cell = 0; cell < on_model.size(); ++cell)
    if ((on_model[cell] & ~image_edges_[cell]) != 0) match.missing += static_cast<size_t>(cell_);
  return match;
}

bool showsLongContours(const EdgeImage& image) {
  return ImageContours(image).size() >= static_cast<size_t>(image.width());
}

}  // namespace edge_mcl
