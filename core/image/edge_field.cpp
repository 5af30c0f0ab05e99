#include "edge_mcl/core/image/edge_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/image/table_kernel.h"

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

/// An edge pixel in the axes of the transform. Rows are counted along the longer axis of the
/// normal.
struct RowPixel {
  int row, column;
};

/// Distance transform along one direction. Rows are processed one after the other, and columns
/// shift by `slope` per row. So every pixel lies on exactly one digital line, and whole rows are
/// processed at once.
/// @param pixels ascending by row.
/// @param steps rows of `cols` elements, with one element `none` before and one after each row.
void directionalTransform(const std::vector<RowPixel>& pixels, int rows, int cols, double slope,
                          uint8_t none, uint8_t* steps, size_t stride) {
  const auto shiftAt = [&](int r) {
    return static_cast<int>(std::lround(slope * r) - std::lround(slope * (r - 1)));
  };
  std::vector<uint8_t> above(cols, 0), here(cols, 0);
  auto next = pixels.begin();
  for (int r = 0; r < rows; ++r) {
    uint8_t* s = steps + static_cast<size_t>(r) * stride;
    std::fill(s - 1, s + cols + 1, none);
    const auto first = next;
    for (; next != pixels.end() && next->row == r; ++next) s[next->column] = 0;
    if (r == 0) {
      for (auto p = first; p != next; ++p) above[p->column] = 1;
      continue;
    }
    const int shift = shiftAt(r);
    std::fill(here.begin(), here.end(), uint8_t{0});
    for (auto p = first; p != next; ++p) {
      here[p->column] = 1;
      // A diagonal step can pass between two edge pixels that touch diagonally.
      const int x = p->column + shift;
      if (shift != 0 && x >= 0 && x < cols && above[x]) s[x] = 0;
    }
    // The value at column x comes from column x - shift of the row before.
    relaxRow(s - stride - shift, none, s, cols);
    above.swap(here);
  }
  for (int r = rows - 2; r >= 0; --r) {
    uint8_t* s = steps + static_cast<size_t>(r) * stride;
    relaxRow(s + stride + shiftAt(r + 1), none, s, cols);
  }
}

/// Number of pixels of every cell that are inside the image and not ignored.
cv::Mat usableArea(const cv::Mat& ignore, int rows, int columns, int width, int height) {
  constexpr int kCell = EdgeField::kClutterCell;
  cv::Mat area(rows, columns, CV_32F);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const cv::Rect cell(c * kCell, r * kCell, std::min(kCell, width - c * kCell),
                          std::min(kCell, height - r * kCell));
      const int ignored = ignore.empty() ? 0 : cv::countNonZero(ignore(cell));
      area.at<float>(r, c) = static_cast<float>(cell.area() - ignored);
    }
  return area;
}

/// Sum over a window around every cell. Cells outside the image count as zero.
cv::Mat windowSum(const cv::Mat& cells, int window_cells) {
  cv::Mat sum;
  cv::boxFilter(cells, sum, CV_32F, cv::Size(window_cells, window_cells), cv::Point(-1, -1), false,
                cv::BORDER_CONSTANT);
  return sum;
}

/// Stores the number of edge pixels per usable pixel, in a window around every cell. An edge across
/// the normal has one pixel per row of the search. So this is also the number of edges per pixel of
/// the normal.
/// @param pixels number of usable pixels in the window.
void storeClutter(const cv::Mat& count, const cv::Mat& pixels, int window_cells, float* out) {
  const cv::Mat edges = windowSum(count, window_cells);
  for (int y = 0; y < count.rows; ++y)
    for (int x = 0; x < count.cols; ++x) {
      const float size = std::max(pixels.at<float>(y, x), 1.0f);
      // One line through the window is subtracted, because the model edge itself leaves one.
      *out++ = std::max(0.0f, edges.at<float>(y, x) / size - 1 / std::sqrt(size));
    }
}

Eigen::Vector2d normalOfBin(int bin, int bins) {
  const Eigen::Vector2d direction = diamondDirection(2.0 * bin / bins);
  return {-direction.y(), direction.x()};
}

/// Whether the x axis is the longer axis of the normal.
bool isTransposed(const Eigen::Vector2d& normal) {
  return std::abs(normal.x()) > std::abs(normal.y());
}

/// Columns to shift per row, in the axes of the transform.
double slopeOf(const Eigen::Vector2d& normal) {
  return isTransposed(normal) ? normal.y() / normal.x() : normal.x() / normal.y();
}

/// The edge pixels ordered by column, then row.
std::vector<const EdgePixel*> sortedByColumn(const EdgePixels& pixels) {
  std::vector<size_t> next(pixels.width() + 1, 0);
  for (const EdgePixel& p : pixels.list()) ++next[p.x + 1];
  for (int x = 0; x < pixels.width(); ++x) next[x + 1] += next[x];
  std::vector<const EdgePixel*> sorted(pixels.list().size());
  for (const EdgePixel& p : pixels.list()) sorted[next[p.x]++] = &p;
  return sorted;
}

}  // namespace

SearchGeometry::SearchGeometry(const ImageParameters& params) : length_(params.search_length) {
  for (int bin = 0; bin < params.orientation_bins; ++bin) {
    const Eigen::Vector2d normal = normalOfBin(bin, params.orientation_bins);
    walk_.push_back({static_cast<float>(normal.y()), static_cast<float>(-normal.x()),
                     isTransposed(normal), slopeOf(normal)});
    step_length_.push_back(std::hypot(1.0, walk_.back().slope));
    no_edge_.push_back(static_cast<uint8_t>(std::floor(length_ / step_length_.back()) + 1));
  }
}

EdgeField::EdgeField(const EdgeImage& image, const EdgePixels& pixels,
                     const ImageParameters& params)
    : width_(image.width()),
      height_(image.height()),
      search_(params),
      stride_((static_cast<size_t>(width_) + 7) / 8 * 8 + 2),
      steps_(bins() * plane() + 8),
      clutter_rows_((height_ + kClutterCell - 1) / kClutterCell),
      clutter_columns_((width_ + kClutterCell - 1) / kClutterCell),
      clutter_(static_cast<size_t>(bins()) * clutter_rows_ * clutter_columns_),
      ignore_(image.ignore) {
  const auto sine = static_cast<float>(std::sin(params.orientation_tolerance_deg * M_PI / 180));
  const int window_cells = windowCells(params);
  const cv::Mat usable = windowSum(
      usableArea(ignore_, clutter_rows_, clutter_columns_, width_, height_), window_cells);
  const std::vector<const EdgePixel*> by_column = sortedByColumn(pixels);

  tbb::parallel_for(0, bins(), [&](int bin) {
    const SearchGeometry::Walk& walk = search_.walk(bin);
    const bool transposed = walk.transposed;
    cv::Mat count = cv::Mat::zeros(clutter_rows_, clutter_columns_, CV_32F);
    std::vector<RowPixel> matching;
    const auto add = [&](const EdgePixel& p) {
      // The sine of the angle between the two lines is |edge normal . model direction|.
      if (std::abs(p.normal_x * walk.du + p.normal_y * walk.dv) > sine) return;
      matching.push_back(transposed ? RowPixel{p.x, p.y} : RowPixel{p.y, p.x});
      count.at<float>(p.y / kClutterCell, p.x / kClutterCell) += 1;
    };
    if (transposed)
      for (const EdgePixel* p : by_column) add(*p);
    else
      for (const EdgePixel& p : pixels.list()) add(p);
    storeClutter(count, usable, window_cells,
                 &clutter_[static_cast<size_t>(bin) * clutter_rows_ * clutter_columns_]);
    uint8_t* out = &steps_[static_cast<size_t>(bin) * plane() + 1];
    const uint8_t none = search_.noEdge(bin);
    if (transposed) {
      const size_t turned_stride = static_cast<size_t>(height_) + 2;
      LargeBuffer<uint8_t> turned(turned_stride * width_);
      directionalTransform(matching, width_, height_, walk.slope, none, turned.data() + 1,
                           turned_stride);
      const cv::Mat from(width_, height_, CV_8U, turned.data() + 1, turned_stride);
      cv::Mat to(height_, width_, CV_8U, out, stride_);
      cv::transpose(from, to);
    } else {
      directionalTransform(matching, height_, width_, walk.slope, none, out, stride_);
    }
  });
}

double EdgeField::distance(int bin, int x, int y) const {
  const uint8_t s = steps(bin)[static_cast<size_t>(y) * stride_ + x];
  if (s == search_.noEdge(bin)) return std::numeric_limits<double>::infinity();
  return s * search_.stepLength(bin);
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
