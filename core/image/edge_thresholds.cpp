#include "edge_mcl/core/image/edge_thresholds.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace edge_mcl {

namespace {

/// Squared gradients of every third pixel of every third row.
struct Samples {
  std::vector<uint32_t> squares;  // outside the mask, in any order
  std::vector<int32_t> counts;    // (tile, level)
};

/// The strong threshold of the whole image and the lowest one of a tile.
struct Limits {
  double strong, lowest;
};

/// Reorders the squares. @param least lower limit of both
Limits limitsOf(std::vector<uint32_t>* squares, const ImageParameters& params, double least) {
  if (squares->empty()) return {least, least};
  auto sorted_below = squares->begin();  // no element from here on is smaller than one before
  const auto quantile = [&](double q) {  // calls need growing q
    const auto nth =
        squares->begin() + static_cast<long>(q * static_cast<double>(squares->size() - 1));
    std::nth_element(sorted_below, nth, squares->end());
    sorted_below = nth;
    return std::sqrt(static_cast<double>(*nth));
  };
  // The magnitude of Gaussian noise has a Rayleigh distribution, with a median of 1.177 sigma. The
  // lower quartile (0.759 sigma) is still noise when texture fills half of the image.
  const bool edges_are_few = params.edge_share <= 0.75;
  const double first = quantile(edges_are_few ? 0.25 : 1 - params.edge_share);
  const double second = quantile(edges_are_few ? 1 - params.edge_share : 0.25);
  const double noise = (edges_are_few ? first : second) / 0.759;
  const double floor = std::max(least, params.noise_factor * noise);
  const double strong = std::max(floor, edges_are_few ? second : first);
  return {strong, floor};
}

/// Square that a share of the counted ones exceeds, rounded up to the next level.
uint32_t exceededBy(double share, const std::array<int32_t, EdgeThresholds::kLevels>& counts) {
  int64_t total = 0;
  for (const int32_t count : counts) total += count;
  const auto most = static_cast<int64_t>(share * static_cast<double>(total));
  int64_t above = 0;
  int level = EdgeThresholds::kLevels;
  while (level > 0) {
    above += counts[level - 1];
    if (above > most) break;
    --level;
  }
  return EdgeThresholds::lowestOf(level);
}

}  // namespace

int EdgeThresholds::tileOf(const ImageParameters& params) {
  constexpr int kSmallest = 8;  // pixels; a smaller one holds too few samples
  return params.contrast_window > 0 ? std::max(kSmallest, params.contrast_window / 3) : 0;
}

int EdgeThresholds::levelOf(uint32_t square) {
  if (square < 4) return static_cast<int>(square);
  const int top = 31 - __builtin_clz(square);
  return 4 * (top - 1) + static_cast<int>((square >> (top - 2)) & 3);
}

uint32_t EdgeThresholds::lowestOf(int level) {
  if (level < 4) return static_cast<uint32_t>(level);
  return static_cast<uint32_t>(4 + level % 4) << (level / 4 - 1);
}

EdgeThresholds::Squares EdgeThresholds::squaresOf(double strong,
                                                  const ImageParameters& params) const {
  constexpr double kMost = 32767;  // limit of cv::Canny
  const double high = std::min(kMost, strong), low = std::min(kMost, params.hysteresis * strong);
  return {static_cast<int32_t>(std::floor(low * low)),
          static_cast<int32_t>(std::floor(high * high))};
}

EdgeThresholds::EdgeThresholds(const cv::Mat& gradient_x, const cv::Mat& gradient_y,
                               const cv::Mat& ignore, const ImageParameters& params, double least)
    : tile_(tileOf(params)) {
  if (tile_ > 0) {
    columns_ = (gradient_x.cols + tile_ - 1) / tile_;
    rows_ = (gradient_x.rows + tile_ - 1) / tile_;
  }
  Samples samples;
  samples.squares.reserve(gradient_x.total() / 9 + 1);
  const size_t tiles = static_cast<size_t>(rows_) * static_cast<size_t>(columns_);
  if (tile_ > 0) samples.counts.assign(tiles * kLevels, 0);
  for (int y = 1; y < gradient_x.rows; y += 3) {
    const int16_t *gx = gradient_x.ptr<int16_t>(y), *gy = gradient_y.ptr<int16_t>(y);
    const uint8_t* ignored = ignore.empty() ? nullptr : ignore.ptr<uint8_t>(y);
    int32_t* counts = tile_ > 0 ? &samples.counts[indexOf(0, y / tile_) * kLevels] : nullptr;
    int next = tile_;  // first column of the next tile
    for (int x = 1; x < gradient_x.cols; x += 3) {
      if (counts && x >= next) {
        counts += kLevels;
        next += tile_;
      }
      if (ignored && ignored[x]) continue;
      const auto square = static_cast<uint32_t>(gx[x] * gx[x] + gy[x] * gy[x]);
      samples.squares.push_back(square);
      if (counts) ++counts[levelOf(square)];
    }
  }
  const Limits limits = limitsOf(&samples.squares, params, least);
  strong_ = limits.strong;
  tiles_.assign(tiles, squaresOf(strong_, params));
  for (int row = 0; tile_ > 0 && row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      std::array<int32_t, kLevels> around{};
      for (int r = std::max(0, row - 1); r <= std::min(rows_ - 1, row + 1); ++r)
        for (int c = std::max(0, column - 1); c <= std::min(columns_ - 1, column + 1); ++c) {
          const int32_t* counts = &samples.counts[indexOf(c, r) * kLevels];
          for (int level = 0; level < kLevels; ++level) around[level] += counts[level];
        }
      const double own = std::sqrt(static_cast<double>(exceededBy(params.edge_share, around)));
      const double strong = std::min(strong_, std::max(limits.lowest, std::sqrt(own * strong_)));
      tiles_[indexOf(column, row)] = squaresOf(strong, params);
    }
}

}  // namespace edge_mcl
