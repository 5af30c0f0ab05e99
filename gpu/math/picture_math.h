/// Finds the edges of a grey image for every direction bin. The functions are the bodies of the
/// kernels, for host and device. Each makes one element of its output. code_math.h has the next
/// steps. All values are whole numbers or are rounded as on the host, so that host and device make
/// the same bits as edge_mcl::findEdges, EdgeField and ScoreTable.
#pragma once

#include "edge_mcl/gpu/math/sample_math.h"

namespace edge_mcl::gpu {

constexpr int kMostBins = 32;        ///< largest number of direction bins; each has a bit
constexpr int kMostBlurRadius = 31;  ///< pixels
constexpr int kClutterCell = 8;      ///< width of an image cell, pixels, see edge_mcl::EdgeField
constexpr int kWord = 32;            ///< pixels along a normal that are the bits of a word

/// One direction bin, see edge_mcl::SearchGeometry.
struct DirectionBin {
  float du, dv;        ///< unit direction of the model edge in the image
  int32_t transposed;  ///< the normal is walked column by column
  int32_t no_edge;     ///< number of steps that means "no edge in reach"
};

/// Sizes and buffers. Every kernel gets them by value. "Cell" means an image cell here.
struct PictureWork {
  int32_t width, height, bins, levels, entries, window_cells;
  int32_t cell_columns, cell_rows, longest;  ///< longest: the larger of width and height
  int32_t blur_radius, gradient_scale;
  int32_t blur[kMostBlurRadius + 1];  ///< weights in 1/64, see edge_mcl::blurWeights
  float sine;                         ///< sine of the orientation tolerance
  double edge_share, noise_factor, hysteresis, least_threshold;
  int32_t tile, tile_columns, tile_rows;  ///< tile: side in pixels; 0: one threshold for all

  // Arrays of the recipe.
  const DirectionBin* direction;  ///< (bin)
  const int32_t* shift;           ///< (bin, row): columns walked from row 0 to this row
  const uint8_t* level_codes;     ///< (bin, level, steps)
  const float* level_borders;     ///< (level), levels - 1 elements

  // Arrays of the picture, all row-major.
  const uint8_t* grey;
  const uint8_t* ignore;  ///< null without a mask
  int16_t* smooth;        ///< smoothed grey times gradient_scale
  int16_t *gradient_x, *gradient_y;
  uint32_t* sampled;       ///< squared magnitudes for the thresholds, kIgnoredSample where ignored
  int32_t* sampled_count;  ///< (tile, level): number of samples; only with tiles
  double* limits;          ///< strong threshold of the image, lowest strong threshold of a tile
  int32_t* threshold;      ///< (tile): weak and strong threshold, squared
  int32_t* parent;  ///< for an edge candidate: a candidate that it is connected to; otherwise -1
  uint8_t* strong;  ///< for the root of a tree of candidates: 1 when the tree has a strong edge
  uint32_t* match;  ///< bit b: edge pixel of direction bin b
  uint32_t* hit;    ///< as match, with the additional pixels of slipPixel()
  int32_t* count;   ///< (bin, cell): number of edge pixels
  int32_t* usable;  ///< (cell): number of pixels that are not ignored; only with `ignore`
  uint8_t* level;   ///< (bin, cell): level of the density of edges
  uint8_t* codes;   ///< (bin, y, x)
  Quad* quads;      ///< (bin, y, x): the table
};

constexpr uint32_t kIgnoredSample = 0xffffffffu;

EDGE_MCL_DEVICE_FUNCTION int clampTo(int value, int size) {
  return value < 0 ? 0 : (value >= size ? size - 1 : value);
}

/// The thresholds use the gradient magnitude of every third pixel in either direction.
EDGE_MCL_DEVICE_FUNCTION int sampledColumns(const PictureWork& w) { return (w.width + 1) / 3; }
EDGE_MCL_DEVICE_FUNCTION int sampledRows(const PictureWork& w) { return (w.height + 1) / 3; }

/// Levels of squared gradients, see edge_mcl::EdgeThresholds.
constexpr int kSquareLevels = 120;

EDGE_MCL_DEVICE_FUNCTION int leadingZeros(uint32_t value) {  // value is not 0
#if defined(__CUDA_ARCH__)
  return __clz(static_cast<int>(value));
#else
  return __builtin_clz(value);
#endif
}

/// Adds to *at, atomically on the device.
EDGE_MCL_DEVICE_FUNCTION void addTo(int32_t* at, int32_t value) {
#if defined(__CUDA_ARCH__)
  atomicAdd(at, value);
#else
  *at += value;
#endif
}

EDGE_MCL_DEVICE_FUNCTION int levelOfSquare(uint32_t square) {
  if (square < 4) return static_cast<int>(square);
  const int top = 31 - leadingZeros(square);
  return 4 * (top - 1) + static_cast<int>((square >> (top - 2)) & 3);
}

EDGE_MCL_DEVICE_FUNCTION uint32_t lowestOfLevel(int level) {
  if (level < 4) return static_cast<uint32_t>(level);
  return static_cast<uint32_t>(4 + level % 4) << (level / 4 - 1);
}

EDGE_MCL_DEVICE_FUNCTION int32_t tilesOf(const PictureWork& w) {
  return w.tile > 0 ? w.tile_columns * w.tile_rows : 1;
}

EDGE_MCL_DEVICE_FUNCTION int32_t tileAt(const PictureWork& w, int x, int y) {
  return w.tile > 0 ? y / w.tile * w.tile_columns + x / w.tile : 0;
}

/// Computes the smoothed grey value times gradient_scale, rounded half to even. It also clears the
/// counts of the image cells and of the tiles.
EDGE_MCL_DEVICE_FUNCTION void smoothPixel(const PictureWork& w, int x, int y) {
  const int32_t at = y * w.width + x, pixels = w.width * w.height;
  const int32_t cells = w.cell_columns * w.cell_rows;
  for (int32_t i = at; i < w.bins * cells; i += pixels) w.count[i] = 0;
  if (w.tile > 0)
    for (int32_t i = at; i < tilesOf(w) * kSquareLevels; i += pixels) w.sampled_count[i] = 0;
  if (w.ignore && at < cells) {
    const int right = w.width - at % w.cell_columns * kClutterCell;
    const int below = w.height - at / w.cell_columns * kClutterCell;
    w.usable[at] = (right < kClutterCell ? right : kClutterCell) *
                   (below < kClutterCell ? below : kClutterCell);
  }
  int32_t sum = 0;           // at most 64 * 64 * 255
  if (w.blur_radius == 2) {  // the default, unrolled
    const int32_t b0 = w.blur[0], b1 = w.blur[1], b2 = w.blur[2];
    const int x0 = clampTo(x - 2, w.width), x1 = clampTo(x - 1, w.width);
    const int x3 = clampTo(x + 1, w.width), x4 = clampTo(x + 2, w.width);
    const auto row = [&](int dy) {
      const uint8_t* p = w.grey + clampTo(y + dy, w.height) * w.width;
      return b0 * p[x] + b1 * (p[x1] + p[x3]) + b2 * (p[x0] + p[x4]);
    };
    sum = b0 * row(0) + b1 * (row(-1) + row(1)) + b2 * (row(-2) + row(2));
  } else {
    for (int dy = -w.blur_radius; dy <= w.blur_radius; ++dy) {
      const uint8_t* row = w.grey + clampTo(y + dy, w.height) * w.width;
      int32_t of_row = 0;
      for (int dx = -w.blur_radius; dx <= w.blur_radius; ++dx)
        of_row += w.blur[dx < 0 ? -dx : dx] * row[clampTo(x + dx, w.width)];
      sum += w.blur[dy < 0 ? -dy : dy] * of_row;
    }
  }
  const int32_t exact = sum * w.gradient_scale;  // in 1/4096
  const int32_t whole = exact >> 12, rest = exact & 4095;
  const bool up = rest > 2048 || (rest == 2048 && (whole & 1));
  w.smooth[at] = static_cast<int16_t>(whole + up);
}

/// Computes the gradient with Scharr's operator, and its squared magnitude for every third pixel.
EDGE_MCL_DEVICE_FUNCTION void gradientOfPixel(const PictureWork& w, int x, int y) {
  const int left = clampTo(x - 1, w.width), right = clampTo(x + 1, w.width);
  const int16_t* above = w.smooth + static_cast<int64_t>(clampTo(y - 1, w.height)) * w.width;
  const int16_t* here = w.smooth + static_cast<int64_t>(y) * w.width;
  const int16_t* below = w.smooth + static_cast<int64_t>(clampTo(y + 1, w.height)) * w.width;
  const int gx = 3 * (above[right] - above[left]) + 10 * (here[right] - here[left]) +
                 3 * (below[right] - below[left]);
  const int gy = 3 * (below[left] - above[left]) + 10 * (below[x] - above[x]) +
                 3 * (below[right] - above[right]);
  const int64_t at = static_cast<int64_t>(y) * w.width + x;
  w.gradient_x[at] = static_cast<int16_t>(gx);
  w.gradient_y[at] = static_cast<int16_t>(gy);
  if (x % 3 != 1 || y % 3 != 1) return;
  const bool ignored = w.ignore && w.ignore[at];
  const auto square = static_cast<uint32_t>(gx * gx + gy * gy);
  w.sampled[static_cast<int64_t>(y / 3) * sampledColumns(w) + x / 3] =
      ignored ? kIgnoredSample : square;
  if (w.tile > 0 && !ignored)
    addTo(w.sampled_count + tileAt(w, x, y) * kSquareLevels + levelOfSquare(square), 1);
}

/// Ranks of the two order statistics on which the thresholds depend.
struct QuantileRanks {
  uint32_t noise, edges;
};
/// @param count number of squared magnitudes that are not ignored.
EDGE_MCL_DEVICE_FUNCTION QuantileRanks quantileRanks(const PictureWork& w, uint32_t count) {
  const double last = static_cast<double>(count) - 1;
  return {static_cast<uint32_t>(0.25 * last), static_cast<uint32_t>((1 - w.edge_share) * last)};
}

/// Sets the limits of the thresholds, see edge_mcl::EdgeThresholds. @param noise, edges squared
/// magnitudes of the ranks of QuantileRanks. @param count number of squared magnitudes; 0: all
/// pixels are ignored.
EDGE_MCL_DEVICE_FUNCTION void setLimits(const PictureWork& w, uint32_t count, uint32_t noise,
                                        uint32_t edges) {
  double lowest = w.least_threshold, strong = w.least_threshold;
  if (count > 0) {
    lowest = fmax(lowest, w.noise_factor * (sqrt(static_cast<double>(noise)) / 0.759));
    strong = fmax(lowest, sqrt(static_cast<double>(edges)));
  }
  w.limits[0] = strong;
  w.limits[1] = lowest;
}

/// Number of samples of a level in a tile and its neighbours.
EDGE_MCL_DEVICE_FUNCTION int32_t samplesAround(const PictureWork& w, int column, int row,
                                               int level) {
  int32_t sum = 0;
  for (int r = row > 0 ? row - 1 : 0; r <= row + 1 && r < w.tile_rows; ++r)
    for (int c = column > 0 ? column - 1 : 0; c <= column + 1 && c < w.tile_columns; ++c)
      sum += w.sampled_count[(r * w.tile_columns + c) * kSquareLevels + level];
  return sum;
}

/// Sets the thresholds of a tile. @param around samplesAround() of every level; null: the tile is
/// the whole image.
EDGE_MCL_DEVICE_FUNCTION void setThresholds(const PictureWork& w, int tile, const int32_t* around) {
  double strong = w.limits[0];
  if (around) {
    int64_t total = 0, above = 0;
    for (int level = 0; level < kSquareLevels; ++level) total += around[level];
    const auto most = static_cast<int64_t>(w.edge_share * static_cast<double>(total));
    int level = kSquareLevels;
    for (; level > 0; --level) {
      above += around[level - 1];
      if (above > most) break;
    }
    const double own = sqrt(static_cast<double>(lowestOfLevel(level)));
    strong = fmin(strong, fmax(w.limits[1], sqrt(own * strong)));
  }
  // Thresholds are limited and squared as in cv::Canny.
  const double high = fmin(32767.0, strong), low = fmin(32767.0, w.hysteresis * strong);
  w.threshold[2 * tile] = static_cast<int32_t>(floor(low * low));
  w.threshold[2 * tile + 1] = static_cast<int32_t>(floor(high * high));
}

/// Squared magnitude of the gradient; 0 outside of the image.
EDGE_MCL_DEVICE_FUNCTION int32_t squareAt(const PictureWork& w, int x, int y) {
  if (x < 0 || y < 0 || x >= w.width || y >= w.height) return 0;
  const int64_t at = static_cast<int64_t>(y) * w.width + x;
  return w.gradient_x[at] * w.gradient_x[at] + w.gradient_y[at] * w.gradient_y[at];
}

/// Whether the magnitude is the largest along the gradient. Thins edges as cv::Canny does: the
/// direction of the gradient is rounded to one of four (tan 22.5 degrees in fixed point).
EDGE_MCL_DEVICE_FUNCTION bool isRidge(const PictureWork& w, int x, int y, int32_t square) {
  const int64_t at = static_cast<int64_t>(y) * w.width + x;
  const int32_t gx = w.gradient_x[at], gy = w.gradient_y[at];
  const auto ax = static_cast<uint32_t>(gx < 0 ? -gx : gx);
  const auto ay = static_cast<uint32_t>(gy < 0 ? -gy : gy) << 15;
  const uint32_t flat = ax * 13573u;
  if (ay < flat) return square > squareAt(w, x - 1, y) && square >= squareAt(w, x + 1, y);
  // cv::Canny compares signed numbers here, which wrap around.
  if (static_cast<int32_t>(ay) > static_cast<int32_t>(flat + (ax << 16)))
    return square > squareAt(w, x, y - 1) && square >= squareAt(w, x, y + 1);
  const int side = (gx ^ gy) < 0 ? -1 : 1;
  return square > squareAt(w, x - side, y - 1) && square > squareAt(w, x + side, y + 1);
}

/// Whether a pixel is an edge candidate: above the weak threshold and on a ridge.
EDGE_MCL_DEVICE_FUNCTION bool isCandidate(const PictureWork& w, int x, int y) {
  const int32_t square = squareAt(w, x, y);
  return square > w.threshold[2 * tileAt(w, x, y)] && isRidge(w, x, y, square);
}

/// Lowers *at to the value if the value is smaller, atomically on the device. @return the old
/// value.
EDGE_MCL_DEVICE_FUNCTION int32_t lowerTo(int32_t* at, int32_t value) {
#if defined(__CUDA_ARCH__)
  return atomicMin(at, value);
#else
  const int32_t before = *at;
  if (value < before) *at = value;
  return before;
#endif
}

EDGE_MCL_DEVICE_FUNCTION int trailingZeros(uint32_t value) {  // value is not 0
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(value)) - 1;
#else
  return __builtin_ctz(value);
#endif
}

/// Returns the root of a tree. It shortens the path for later calls: every pixel on the path gets
/// its grandparent as parent. Several threads may do this at the same time, because the new parent
/// is always an ancestor.
EDGE_MCL_DEVICE_FUNCTION int32_t rootOf(int32_t* parent, int32_t i) {
  int32_t next = parent[i];
  while (next != i) {
    const int32_t after = parent[next];
    if (after != next) parent[i] = after;
    i = next;
    next = after;
  }
  return i;
}

/// Joins two trees. The smaller number becomes the root, in any order of the calls.
EDGE_MCL_DEVICE_FUNCTION void unite(int32_t* parent, int32_t a, int32_t b) {
  while (true) {
    a = rootOf(parent, a);
    b = rootOf(parent, b);
    if (a == b) return;
    if (a < b) {
      const int32_t swapped = a;
      a = b;
      b = swapped;
    }
    const int32_t before = lowerTo(parent + a, b);
    if (before == a) return;
    a = before;  // another thread was faster
  }
}

/// Connects a candidate to the neighbouring candidates that come before it (left and above) and lie
/// in the rows from y0 on and the columns x0 to x1. @param at number of the pixel in `parent`,
/// whose rows have `stride` elements.
EDGE_MCL_DEVICE_FUNCTION void connectPixel(int32_t* parent, int32_t at, int32_t stride, int x,
                                           int y, int x0, int x1, int y0) {
  if (parent[at] < 0) return;
  if (x > x0 && parent[at - 1] >= 0) unite(parent, at, at - 1);
  if (y <= y0) return;
  for (int dx = x > x0 ? -1 : 0; dx <= 1 && x + dx <= x1; ++dx)
    if (parent[at - stride + dx] >= 0) unite(parent, at, at - stride + dx);
}

/// Marks the tree of a candidate above the strong threshold. All candidates of this tree are edges.
EDGE_MCL_DEVICE_FUNCTION void markStrong(const PictureWork& w, int x, int y) {
  const int32_t at = y * w.width + x;
  if (w.parent[at] >= 0 && squareAt(w, x, y) > w.threshold[2 * tileAt(w, x, y) + 1])
    w.strong[rootOf(w.parent, at)] = 1;
}

/// Finds the direction bins that an edge pixel matches, and counts the pixel in its image cell.
EDGE_MCL_DEVICE_FUNCTION void matchPixel(const PictureWork& w, int x, int y) {
  const int32_t at = y * w.width + x;
  const int32_t cells = w.cell_columns * w.cell_rows;
  const int32_t cell = y / kClutterCell * w.cell_columns + x / kClutterCell;
  const bool ignored = w.ignore && w.ignore[at];
  if (ignored) addTo(w.usable + cell, -1);
  uint32_t bits = 0;
  if (w.parent[at] >= 0 && !ignored && w.strong[rootOf(w.parent, at)]) {
    const double gx = w.gradient_x[at], gy = w.gradient_y[at];
    const double norm = sqrt(gx * gx + gy * gy);
    const auto nx = static_cast<float>(gx / norm), ny = static_cast<float>(gy / norm);
    for (int b = 0; b < w.bins; ++b) {
      const DirectionBin& bin = w.direction[b];
      if (!(fabsf(nx * bin.du + ny * bin.dv) <= w.sine)) continue;
      bits |= 1u << b;
      addTo(w.count + b * cells + cell, 1);
    }
  }
  w.match[at] = bits;
}

/// Adds hits, for every bin, where a diagonal step along a normal would pass between two diagonally
/// connected edge pixels without touching them.
EDGE_MCL_DEVICE_FUNCTION void slipPixel(const PictureWork& w, int x, int y) {
  const int32_t at = y * w.width + x;
  const uint32_t here = w.match[at];
  uint32_t bits = here;
  // Both edge pixels lie beside this pixel: one left or right of it, one above or below it.
  const uint32_t left = x > 0 ? w.match[at - 1] : 0, right = x + 1 < w.width ? w.match[at + 1] : 0;
  const uint32_t above = y > 0 ? w.match[at - w.width] : 0;
  const uint32_t below = y + 1 < w.height ? w.match[at + w.width] : 0;
  if ((left | right) & (above | below)) {
    for (int b = 0; b < w.bins; ++b) {
      const bool turned = w.direction[b].transposed;
      const int row = turned ? x : y;
      if (row == 0) continue;
      const int32_t* shift = w.shift + static_cast<int64_t>(b) * w.longest + row;
      const int step = shift[0] - shift[-1];
      if (step == 0) continue;
      const uint32_t before = turned ? left : above;  // the row before, the same column
      const uint32_t beside =                         // the same row, column - step
          turned ? (step > 0 ? above : below) : (step > 0 ? left : right);
      bits |= before & beside & (1u << b);
    }
  }
  w.hit[at] = bits;
}

/// Computes the level of the density of edges around an image cell, see
/// edge_mcl::EdgeField::clutter.
EDGE_MCL_DEVICE_FUNCTION void levelOfCell(const PictureWork& w, int bin, int column, int row) {
  const int half = w.window_cells / 2, cells = w.cell_columns * w.cell_rows;
  const int32_t* count = w.count + bin * cells;
  const int c0 = column > half ? column - half : 0, r0 = row > half ? row - half : 0;
  const int c1 = column + half < w.cell_columns ? column + half + 1 : w.cell_columns;
  const int r1 = row + half < w.cell_rows ? row + half + 1 : w.cell_rows;
  int32_t edges = 0, pixels = 0;
  for (int r = r0; r < r1; ++r) {
#if defined(__CUDA_ARCH__)
#pragma unroll 4
#endif
    for (int c = c0; c < c1; ++c) edges += count[r * w.cell_columns + c];
  }
  if (w.ignore) {
    for (int r = r0; r < r1; ++r)
      for (int c = c0; c < c1; ++c) pixels += w.usable[r * w.cell_columns + c];
  } else {
    const int right = c1 * kClutterCell, bottom = r1 * kClutterCell;
    pixels = ((right < w.width ? right : w.width) - c0 * kClutterCell) *
             ((bottom < w.height ? bottom : w.height) - r0 * kClutterCell);
  }
  const float size = fmaxf(static_cast<float>(pixels), 1.0f);
  const float clutter = fmaxf(0.0f, static_cast<float>(edges) / size - 1 / sqrtf(size));
  int level = 0;
  while (level < w.levels - 1 && !(clutter < w.level_borders[level])) ++level;
  w.level[bin * cells + row * w.cell_columns + column] = static_cast<uint8_t>(level);
}

}  // namespace edge_mcl::gpu
