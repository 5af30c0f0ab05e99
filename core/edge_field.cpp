#include "edge_mcl/core/edge_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace edge_mcl {

double diamondAngle(double du, double dv) {
  if (dv < 0) {
    du = -du;
    dv = -dv;
  }
  const double sum = std::abs(du) + dv;
  if (!(sum > 0)) return 0;
  const double p = du >= 0 ? dv / sum : 2 - dv / sum;
  return p >= 2 ? 0 : p;
}

Eigen::Vector2d diamondDirection(double p) {
  return (p <= 1 ? Eigen::Vector2d(1 - p, p) : Eigen::Vector2d(1 - p, 2 - p)).normalized();
}

namespace {

struct EdgePixel {
  int x, y;
  float nx, ny;  // unit gradient
};

std::vector<EdgePixel> listEdgePixels(const EdgeImage& image) {
  std::vector<EdgePixel> pixels;
  for (int y = 0; y < image.height(); ++y) {
    const uint8_t* row = image.edges.ptr<uint8_t>(y);
    for (int x = 0; x < image.width(); ++x) {
      if (!row[x]) continue;
      const Eigen::Vector2d n = image.normalAt(x, y);
      pixels.push_back({x, y, static_cast<float>(n.x()), static_cast<float>(n.y())});
    }
  }
  return pixels;
}

/// Distance transform along one direction. Rows are walked one at a time, columns shift by
/// `slope` per row, so that every pixel lies on exactly one digital line and whole rows are
/// processed at once.
void directionalTransform(const uint8_t* edge, int rows, int cols, double slope, uint8_t none,
                          uint8_t* steps) {
  const auto shiftAt = [&](int r) {
    return static_cast<int>(std::lround(slope * r) - std::lround(slope * (r - 1)));
  };
  const size_t stride = static_cast<size_t>(cols);
  std::vector<uint8_t> padded(stride + 2, none), crossing(stride, 0);
  const auto relax = [&](int r, int from, int shift) {
    // Value at column x comes from column x - shift of row `from`.
    std::memcpy(padded.data() + 1, steps + static_cast<size_t>(from) * stride, stride);
    const uint8_t* source = padded.data() + 1 - shift;
    uint8_t* target = steps + static_cast<size_t>(r) * stride;
    for (int x = 0; x < cols; ++x) {
      const auto next = static_cast<uint8_t>(std::min<int>(source[x] + 1, none));
      target[x] = std::min(target[x], next);
    }
  };
  for (int r = 0; r < rows; ++r) {
    const uint8_t* e = edge + static_cast<size_t>(r) * stride;
    uint8_t* s = steps + static_cast<size_t>(r) * stride;
    for (int x = 0; x < cols; ++x) s[x] = e[x] ? 0 : none;
    if (r == 0) continue;
    const int shift = shiftAt(r);
    if (shift != 0) {
      // A diagonal step can slip between two diagonally connected edge pixels.
      const uint8_t* above = e - stride;
      const int low = std::max(0, shift), high = std::min(cols, cols + shift);
      for (int x = low; x < high; ++x)
        if (above[x] && e[x - shift]) s[x] = 0;
    }
    relax(r, r - 1, shift);
  }
  for (int r = rows - 2; r >= 0; --r) relax(r, r + 1, -shiftAt(r + 1));
}

/// Pixels of every cell that are inside the image and not ignored.
cv::Mat usableArea(const cv::Mat& ignore, int rows, int columns, int width, int height) {
  cv::Mat area = cv::Mat::zeros(rows, columns, CV_32F);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (ignore.empty() || !ignore.ptr<uint8_t>(y)[x])
        area.at<float>(y / EdgeField::kClutterCell, x / EdgeField::kClutterCell) += 1;
  return area;
}

/// Edge pixels per pixel within a window around every cell. An edge across the normal has one
/// pixel per row of the search, so this is also the number of crossings per pixel of the normal.
void storeClutter(const cv::Mat& count, const cv::Mat& area, int window_cells, float* out) {
  cv::Mat edges, pixels;
  const cv::Size window(window_cells, window_cells);
  cv::boxFilter(count, edges, CV_32F, window, cv::Point(-1, -1), false, cv::BORDER_CONSTANT);
  cv::boxFilter(area, pixels, CV_32F, window, cv::Point(-1, -1), false, cv::BORDER_CONSTANT);
  for (int y = 0; y < count.rows; ++y)
    for (int x = 0; x < count.cols; ++x) {
      const float size = std::max(pixels.at<float>(y, x), 1.0f);
      // One line through the window is what a model edge itself would leave.
      *out++ = std::max(0.0f, edges.at<float>(y, x) / size - 1 / std::sqrt(size));
    }
}

}  // namespace

EdgeField::EdgeField(const EdgeImage& image, const ImageParameters& params)
    : width_(image.width()),
      height_(image.height()),
      bins_(params.orientation_bins),
      search_length_(params.search_length),
      steps_(static_cast<size_t>(bins_) * plane()),
      no_edge_(bins_),
      step_length_(bins_),
      clutter_rows_((height_ + kClutterCell - 1) / kClutterCell),
      clutter_columns_((width_ + kClutterCell - 1) / kClutterCell),
      clutter_(static_cast<size_t>(bins_) * clutter_rows_ * clutter_columns_),
      ignore_(image.ignore) {
  const std::vector<EdgePixel> pixels = listEdgePixels(image);
  const double sine = std::sin(params.orientation_tolerance_deg * M_PI / 180);
  const cv::Mat area = usableArea(ignore_, clutter_rows_, clutter_columns_, width_, height_);
  const int window_cells = std::max(1, params.clutter_window / kClutterCell) | 1;

  tbb::parallel_for(0, bins_, [&](int bin) {
    const Eigen::Vector2d direction = diamondDirection(2.0 * bin / bins_);
    const Eigen::Vector2d normal(-direction.y(), direction.x());
    // The table is made with the normal's longer axis as the row axis.
    const bool transposed = std::abs(normal.x()) > std::abs(normal.y());
    const int rows = transposed ? width_ : height_, cols = transposed ? height_ : width_;
    const double slope = transposed ? normal.y() / normal.x() : normal.x() / normal.y();
    step_length_[bin] = std::hypot(1.0, slope);
    no_edge_[bin] = static_cast<uint8_t>(std::floor(search_length_ / step_length_[bin]) + 1);

    cv::Mat count = cv::Mat::zeros(clutter_rows_, clutter_columns_, CV_32F);
    std::vector<uint8_t> edge(plane(), 0);
    for (const EdgePixel& p : pixels) {
      // Angle between line directions: sine of it is |edge normal . model direction|.
      if (std::abs(p.nx * direction.x() + p.ny * direction.y()) > sine) continue;
      edge[transposed ? static_cast<size_t>(p.x) * cols + p.y
                      : static_cast<size_t>(p.y) * cols + p.x] = 1;
      count.at<float>(p.y / kClutterCell, p.x / kClutterCell) += 1;
    }
    storeClutter(count, area, window_cells,
                 &clutter_[static_cast<size_t>(bin) * clutter_rows_ * clutter_columns_]);
    uint8_t* out = &steps_[static_cast<size_t>(bin) * plane()];
    if (transposed) {
      std::vector<uint8_t> turned(plane());
      directionalTransform(edge.data(), rows, cols, slope, no_edge_[bin], turned.data());
      const cv::Mat from(rows, cols, CV_8U, turned.data());
      cv::Mat to(height_, width_, CV_8U, out);
      cv::transpose(from, to);
    } else {
      directionalTransform(edge.data(), rows, cols, slope, no_edge_[bin], out);
    }
  });
}

double EdgeField::distance(int bin, int x, int y) const {
  const uint8_t s = steps(bin)[static_cast<size_t>(y) * width_ + x];
  if (s == no_edge_[bin]) return std::numeric_limits<double>::infinity();
  return s * step_length_[bin];
}

NormalHit searchAlongNormal(const EdgeImage& image, const Eigen::Vector2d& pixel,
                            const Eigen::Vector2d& normal, double length, double tolerance_cos) {
  NormalHit hit;
  const auto test = [&](double t) {
    const int x = static_cast<int>(std::lround(pixel.x() + t * normal.x()));
    const int y = static_cast<int>(std::lround(pixel.y() + t * normal.y()));
    if (x < 0 || y < 0 || x >= image.width() || y >= image.height()) return false;
    if (!image.edges.ptr<uint8_t>(y)[x]) return false;
    if (std::abs(image.normalAt(x, y).dot(normal)) < tolerance_cos) return false;
    hit = {true, t, x, y};
    return true;
  };
  if (test(0)) return hit;
  for (double t = 0.5; t <= length; t += 0.5)
    if (test(t) || test(-t)) return hit;
  return hit;
}

}  // namespace edge_mcl
