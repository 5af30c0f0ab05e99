#include "edge_mcl/core/image/edge_tracing.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace edge_mcl {

namespace {

constexpr uint8_t kCandidate = 1, kEdge = 255;

/// Squared gradients of some rows, with a border of zeros.
class Squares {
 public:
  Squares(const cv::Mat& gradient_x, const cv::Mat& gradient_y, int first, int last)
      : stride_(gradient_x.cols + 2),
        first_(first - 1),
        values_(static_cast<size_t>(last - first + 2) * static_cast<size_t>(stride_), 0) {
    for (int y = std::max(0, first_); y < std::min(gradient_x.rows, last + 1); ++y) {
      const int16_t *gx = gradient_x.ptr<int16_t>(y), *gy = gradient_y.ptr<int16_t>(y);
      int32_t* to = row(y);
      for (int x = 0; x < gradient_x.cols; ++x) to[x] = gx[x] * gx[x] + gy[x] * gy[x];
    }
  }
  int32_t* row(int y) { return values_.data() + (y - first_) * stride_ + 1; }
  ptrdiff_t stride() const { return stride_; }

 private:
  ptrdiff_t stride_;
  int first_;
  std::vector<int32_t> values_;
};

/// Whether the magnitude is the largest along the gradient. Like cv::Canny, it rounds the direction
/// of the gradient to one of four (tan 22.5 degrees in fixed point) and compares signed numbers
/// that may wrap around.
bool isRidge(const int32_t* square, ptrdiff_t stride, int gx, int gy) {
  const auto ax = static_cast<uint32_t>(std::abs(gx));
  const auto ay = static_cast<uint32_t>(std::abs(gy)) << 15;
  const uint32_t flat = ax * 13573u;
  if (ay < flat) return *square > square[-1] && *square >= square[1];
  if (static_cast<int32_t>(ay) > static_cast<int32_t>(flat + (ax << 16)))
    return *square > square[-stride] && *square >= square[stride];
  const ptrdiff_t side = (gx ^ gy) < 0 ? -1 : 1;
  return *square > square[-stride - side] && *square > square[stride + side];
}

}  // namespace

cv::Mat traceEdges(const cv::Mat& gradient_x, const cv::Mat& gradient_y,
                   const EdgeThresholds& thresholds) {
  const int width = gradient_x.cols, height = gradient_x.rows;
  const int tile = thresholds.tile() > 0 ? thresholds.tile() : width;
  // A border of one pixel saves the questions for the neighbours outside.
  cv::Mat marked = cv::Mat::zeros(height + 2, width + 2, CV_8U);
  std::vector<uint8_t*> open;  // strong candidates whose neighbours are not visited yet
  std::mutex mutex;
  constexpr int kRows = 32;  // of a stripe
  cv::parallel_for_(cv::Range(0, (height + kRows - 1) / kRows), [&](const cv::Range& stripes) {
    std::vector<uint8_t*> strong;
    const int first = stripes.start * kRows, last = std::min(height, stripes.end * kRows);
    Squares squares(gradient_x, gradient_y, first, last);
    for (int y = first; y < last; ++y) {
      const int16_t *gx = gradient_x.ptr<int16_t>(y), *gy = gradient_y.ptr<int16_t>(y);
      const int32_t* square = squares.row(y);
      uint8_t* to = marked.ptr<uint8_t>(y + 1) + 1;
      for (int begin = 0; begin < width; begin += tile) {
        const EdgeThresholds::Squares& limit = thresholds.at(begin, y);
        const int end = std::min(width, begin + tile);
        for (int x = begin; x < end; ++x) {
          if (square[x] <= limit.weak || !isRidge(square + x, squares.stride(), gx[x], gy[x]))
            continue;
          const bool is_strong = square[x] > limit.strong;
          to[x] = is_strong ? kEdge : kCandidate;
          if (is_strong) strong.push_back(to + x);
        }
      }
    }
    const std::lock_guard<std::mutex> lock(mutex);
    open.insert(open.end(), strong.begin(), strong.end());
  });
  const auto stride = static_cast<ptrdiff_t>(marked.step);
  const ptrdiff_t neighbours[] = {-stride - 1, -stride,    -stride + 1, -1,
                                  1,           stride - 1, stride,      stride + 1};
  while (!open.empty()) {
    uint8_t* pixel = open.back();
    open.pop_back();
    for (const ptrdiff_t offset : neighbours)
      if (pixel[offset] == kCandidate) {
        pixel[offset] = kEdge;
        open.push_back(pixel + offset);
      }
  }
  cv::Mat edges;
  cv::threshold(marked(cv::Rect(1, 1, width, height)), edges, kCandidate, kEdge, cv::THRESH_BINARY);
  return edges;
}

}  // namespace edge_mcl
