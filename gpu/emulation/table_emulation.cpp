#include "edge_mcl/gpu/emulation/table_emulation.h"

#include <algorithm>

namespace edge_mcl::gpu {

namespace {

struct Buffers {
  std::vector<uint8_t> grey, ignore, strong, level, codes;
  std::vector<int16_t> smooth, gradient_x, gradient_y;
  std::vector<uint32_t> sampled, match, hit;
  std::vector<int32_t> sampled_count, threshold, parent, count, usable;
  std::vector<double> limits;
  std::vector<Quad> quads;
};

std::vector<uint8_t> withoutStride(const uint8_t* from, size_t stride, const PictureWork& w) {
  std::vector<uint8_t> to;
  to.reserve(pixelsOf(w));
  for (int y = 0; y < w.height; ++y)
    to.insert(to.end(), from + y * stride, from + y * stride + w.width);
  return to;
}

template <class F>
void forPixels(const PictureWork& w, F&& body) {
  for (int y = 0; y < w.height; ++y)
    for (int x = 0; x < w.width; ++x) body(w, x, y);
}

void selectLimits(const PictureWork& w) {
  std::vector<uint32_t> squares;
  for (size_t i = 0; i < sampledOf(w); ++i)
    if (w.sampled[i] != kIgnoredSample) squares.push_back(w.sampled[i]);
  std::sort(squares.begin(), squares.end());
  const auto n = static_cast<uint32_t>(squares.size());
  if (n == 0) return setLimits(w, 0, 0, 0);
  const QuantileRanks ranks = quantileRanks(w, n);
  setLimits(w, n, squares[ranks.noise], squares[ranks.edges]);
}

void setThresholds(const PictureWork& w) {
  if (w.tile == 0) return setThresholds(w, 0, nullptr);
  for (int tile = 0; tile < tilesOf(w); ++tile) {
    int32_t around[kSquareLevels];
    for (int level = 0; level < kSquareLevels; ++level)
      around[level] = samplesAround(w, tile % w.tile_columns, tile / w.tile_columns, level);
    setThresholds(w, tile, around);
  }
}

/// Codes the pixels of a bin word by word, along all pixel lines.
void codeBin(const PictureWork& w, int bin) {
  const int no_edge = w.direction[bin].no_edge, reach = reachOf(no_edge);
  const bool turned = w.direction[bin].transposed;
  const int rows = turned ? w.width : w.height, columns = turned ? w.height : w.width;
  std::vector<uint32_t> words(2 * reach + 1);
  for (int first = 0; first < rows; first += kWord)
    for (int column = -kWord; column < columns + kWord; ++column) {
      const DigitalLine line = lineThrough(w, bin, first, column);
      for (int k = -reach; k <= reach; ++k) {
        uint32_t& word = words[k + reach] = 0;
        for (int i = 0; i < kWord; ++i)
          word |= static_cast<uint32_t>(isHit(w, line, first + k * kWord + i)) << i;
      }
      for (int i = 0; i < kWord; ++i)
        if (const LinePixel p = pixelOf(line, first + i); p.inside)
          codePixel(w, bin, p, nearestStep(&words[reach], reach, i, no_edge));
    }
}

}  // namespace

std::vector<Quad> emulateTable(const TableRecipe& recipe, const PictureData& picture) {
  PictureWork w = recipe.work;
  Buffers b;
  const size_t pixels = pixelsOf(w), cells = cellsOf(w), bins = static_cast<size_t>(w.bins);
  b.grey = withoutStride(picture.grey, picture.stride, w);
  if (picture.ignore) b.ignore = withoutStride(picture.ignore, picture.ignore_stride, w);
  b.strong.resize(pixels);
  b.level.resize(bins * cells);
  b.codes.resize(bins * pixels);
  for (auto* v : {&b.smooth, &b.gradient_x, &b.gradient_y}) v->resize(pixels);
  for (auto* v : {&b.match, &b.hit}) v->resize(pixels);
  b.sampled.assign(sampledOf(w), kIgnoredSample);
  const auto tiles = static_cast<size_t>(tilesOf(w));
  b.sampled_count.resize(tiles * kSquareLevels);
  b.limits.resize(2);
  b.threshold.resize(2 * tiles);
  b.parent.resize(pixels);
  b.count.resize(bins * cells);
  b.usable.resize(cells);
  b.quads.resize(quadsOf(w));
  w.direction = recipe.directions.data();
  w.shift = recipe.shifts.data();
  w.level_codes = recipe.level_codes.data();
  w.level_borders = recipe.level_borders.data();
  w.grey = b.grey.data();
  w.ignore = picture.ignore ? b.ignore.data() : nullptr;
  w.smooth = b.smooth.data();
  w.gradient_x = b.gradient_x.data();
  w.gradient_y = b.gradient_y.data();
  w.sampled = b.sampled.data();
  w.sampled_count = b.sampled_count.data();
  w.limits = b.limits.data();
  w.threshold = b.threshold.data();
  w.parent = b.parent.data();
  w.strong = b.strong.data();
  w.match = b.match.data();
  w.hit = b.hit.data();
  w.count = b.count.data();
  w.usable = b.usable.data();
  w.level = b.level.data();
  w.codes = b.codes.data();
  w.quads = b.quads.data();

  forPixels(w, smoothPixel);
  forPixels(w, gradientOfPixel);
  selectLimits(w);
  setThresholds(w);
  forPixels(w, [](const PictureWork& p, int x, int y) {
    const int32_t at = y * p.width + x;
    p.parent[at] = isCandidate(p, x, y) ? at : -1;
    p.strong[at] = 0;
    connectPixel(p.parent, at, p.width, x, y, 0, p.width - 1, 0);
  });
  forPixels(w, markStrong);
  forPixels(w, matchPixel);
  forPixels(w, slipPixel);
  for (int bin = 0; bin < w.bins; ++bin)
    for (int row = 0; row < w.cell_rows; ++row)
      for (int column = 0; column < w.cell_columns; ++column) levelOfCell(w, bin, column, row);
  for (int bin = 0; bin < w.bins; ++bin) codeBin(w, bin);
  forPixels(w, quadUp);
  return b.quads;
}

std::vector<Quad> emulateTable(const Table& table, const uint16_t* pairs) {
  std::vector<Quad> quads(quadsOf(table));
  for (int bin = 0; bin < table.bins; ++bin)
    for (int y = 0; y < table.height; ++y)
      for (int x = 0; x < table.width; ++x) quadOfPairs(table, pairs, bin, x, y, quads.data());
  return quads;
}

}  // namespace edge_mcl::gpu
