#include "edge_mcl/gpu/engine/table_maker.h"

#include <algorithm>
#include <cstring>

#include "edge_mcl/gpu/engine/threshold_kernel.cuh"

namespace edge_mcl::gpu {

namespace {

constexpr int kBlockX = 32, kBlockY = 4;

#define EDGE_MCL_PIXEL_KERNEL(body)                                                       \
  __global__ void __launch_bounds__(kBlockX* kBlockY) body##Kernel(const PictureWork w) { \
    const int x = blockIdx.x * kBlockX + threadIdx.x;                                     \
    const int y = blockIdx.y * kBlockY + threadIdx.y;                                     \
    if (x < w.width && y < w.height) body(w, x, y);                                       \
  }
EDGE_MCL_PIXEL_KERNEL(smoothPixel)
EDGE_MCL_PIXEL_KERNEL(gradientOfPixel)
EDGE_MCL_PIXEL_KERNEL(markStrong)
EDGE_MCL_PIXEL_KERNEL(matchPixel)
EDGE_MCL_PIXEL_KERNEL(quadUp)
#undef EDGE_MCL_PIXEL_KERNEL

dim3 blocksFor(int columns, int rows, int layers = 1) {
  return dim3((columns + kBlockX - 1) / kBlockX, (rows + kBlockY - 1) / kBlockY, layers);
}

/// Does two independent steps at once: the first blocks run levelOfCell(), the others slipPixel().
/// @param cells_x, cells_y numbers of blocks for the image cells of one bin. @param pixels_x number
/// of blocks in a row of pixels.
__global__ void __launch_bounds__(kBlockX* kBlockY)
    levelAndSlipKernel(const PictureWork w, int cells_x, int cells_y, int pixels_x) {
  int block = blockIdx.x;
  const int of_bin = cells_x * cells_y;
  if (block < of_bin * w.bins) {
    const int bin = block / of_bin;
    block -= bin * of_bin;
    const int column = block % cells_x * kBlockX + threadIdx.x;
    const int row = block / cells_x * kBlockY + threadIdx.y;
    if (column < w.cell_columns && row < w.cell_rows) levelOfCell(w, bin, column, row);
    return;
  }
  block -= of_bin * w.bins;
  const int x = block % pixels_x * kBlockX + threadIdx.x;
  const int y = block / pixels_x * kBlockY + threadIdx.y;
  if (x < w.width && y < w.height) slipPixel(w, x, y);
}

__global__ void __launch_bounds__(kBlockX* kBlockY)
    quadOfPairsKernel(const Table table, const uint16_t* __restrict__ pairs,
                      Quad* __restrict__ quads) {
  const int x = blockIdx.x * kBlockX + threadIdx.x;
  const int y = blockIdx.y * kBlockY + threadIdx.y;
  if (x < table.width && y < table.height) quadOfPairs(table, pairs, blockIdx.z, x, y, quads);
}

// Candidates are connected first within tiles, in shared memory, and then across the borders of the
// tiles. The root of a tree is always the smallest pixel number in it, so the order of the steps
// does not matter.

constexpr int kTileX = 32, kTileY = 16;

/// Connects candidates within tiles. The label of a candidate is the smallest number among the
/// candidates that it is connected to in its tile. Labels spread to neighbours and along labels
/// until no label changes.
__global__ void __launch_bounds__(kTileX* kTileY) connectTileKernel(const PictureWork w) {
  __shared__ int32_t labels[2][kTileX * kTileY];
  const int x0 = blockIdx.x * kTileX, y0 = blockIdx.y * kTileY;
  const int tile_x = threadIdx.x, tile_y = threadIdx.y, own = tile_y * kTileX + tile_x;
  const int x = x0 + tile_x, y = y0 + tile_y;
  const bool inside = x < w.width && y < w.height;
  // A row of the tile is a warp, so all candidates of a run in it get their first label at once.
  const bool candidate = inside && isCandidate(w, x, y);
  const unsigned row = __ballot_sync(0xffffffffu, candidate);
  const unsigned gaps = ~row & ((1u << tile_x) - 1);
  int32_t label = candidate ? tile_y * kTileX + (gaps ? kTileX - __clz(gaps) : 0) : -1;
  int from = 0;
  labels[0][own] = label;
  __syncthreads();
  bool changed = true;
  while (__syncthreads_or(changed)) {
    int32_t next = label;
    if (label >= 0) {
      for (int ny = max(tile_y - 1, 0); ny <= min(tile_y + 1, kTileY - 1); ++ny)
        for (int nx = max(tile_x - 1, 0); nx <= min(tile_x + 1, kTileX - 1); ++nx) {
          const int32_t neighbour = labels[from][ny * kTileX + nx];
          if (neighbour >= 0) next = min(next, neighbour);
        }
      next = labels[from][next];
    }
    changed = next != label;
    label = next;
    from = 1 - from;
    labels[from][own] = label;
  }
  if (!inside) return;
  const int32_t at = y * w.width + x;
  w.parent[at] = label < 0 ? -1 : (y0 + label / kTileX) * w.width + x0 + label % kTileX;
  w.strong[at] = 0;
}

__global__ void __launch_bounds__(kBlockX* kBlockY) connectBordersKernel(const PictureWork w) {
  const int x = blockIdx.x * kBlockX + threadIdx.x;
  const int y = blockIdx.y * kBlockY + threadIdx.y;
  if (x >= w.width || y >= w.height) return;
  const int in_x = x % kTileX;
  if (y % kTileY != 0 && in_x != 0 && in_x != kTileX - 1) return;
  connectPixel(w.parent, y * w.width + x, w.width, x, y, 0, w.width - 1, 0);
}

/// Number of successive words of a pixel line that a block works on.
constexpr int kUprightWords = 4;

/// Codes a bin whose normals are walked row by row. Neighbouring lanes have neighbouring pixel
/// lines. Every warp of the block has one word of each line.
template <int kReach>
__device__ void codeUpright(const PictureWork& w, int bin, int column, int first, int lane,
                            int warp, uint32_t (*words)[kBlockX]) {
  const DigitalLine line = lineThrough(w, bin, first, column);
  for (int k = warp; k < kUprightWords + 2 * kReach; k += kBlockY) {
    const int from = first + (k - kReach) * kWord;
    uint32_t word = 0;
#pragma unroll 16
    for (int i = 0; i < kWord; ++i) word |= static_cast<uint32_t>(isHit(w, line, from + i)) << i;
    words[k][lane] = word;
  }
  __syncthreads();
  const int no_edge = w.direction[bin].no_edge, from = first + warp * kWord;
  uint32_t around[2 * kReach + 1];
#pragma unroll
  for (int k = 0; k <= 2 * kReach; ++k) around[k] = words[warp + k][lane];
#pragma unroll 8
  for (int i = 0; i < kWord; ++i) {
    const LinePixel p = pixelOf(line, from + i);
    if (p.inside) codePixel(w, bin, p, nearestStep(around + kReach, kReach, i, no_edge));
  }
}
static_assert(kUprightWords == kBlockY, "a warp for every word");

/// Number of successive words of a pixel line that a warp works on.
constexpr int kTurnedWords = 4;

/// Codes a bin whose normals are walked column by column. The lanes of a warp have the pixels of
/// one pixel line, which lie side by side in the image.
template <int kReach>
__device__ void codeTurned(const PictureWork& w, int bin, int column, int first, int lane,
                           uint32_t* words) {
  const DigitalLine line = lineThrough(w, bin, first, column);
  const int last = min(first + kTurnedWords * kWord, line.rows) - 1;
  const int from = line.start + line.shift[first], to = line.start + line.shift[last];
  if (max(from, to) < 0 || min(from, to) >= line.columns) return;
  for (int k = -kReach; k < kTurnedWords + kReach; ++k) {
    const uint32_t word = __ballot_sync(0xffffffffu, isHit(w, line, first + k * kWord + lane));
    if (lane == 0) words[k + kReach] = word;
  }
  __syncwarp();
  const int no_edge = w.direction[bin].no_edge;
  for (int k = 0; k < kTurnedWords; ++k) {
    const LinePixel p = pixelOf(line, first + k * kWord + lane);
    if (p.inside) codePixel(w, bin, p, nearestStep(words + kReach + k, kReach, lane, no_edge));
  }
}

template <int kReach>
__global__ void __launch_bounds__(kBlockX* kBlockY) codeKernel(const PictureWork w) {
  __shared__ uint32_t words[kBlockY][kTurnedWords + 2 * kReach];
  __shared__ uint32_t upright_words[kUprightWords + 2 * kReach][kBlockX];
  const int bin = blockIdx.z;
  if (w.direction[bin].transposed) {
    const int column = blockIdx.x * kBlockY + threadIdx.y - kTurnedWords * kWord;
    const int first = blockIdx.y * kTurnedWords * kWord;
    if (first < w.width && column < w.height + kTurnedWords * kWord)
      codeTurned<kReach>(w, bin, column, first, threadIdx.x, words[threadIdx.y]);
  } else {
    const int margin = kUprightWords * kWord;
    const int column = blockIdx.x * kBlockX - margin, first = blockIdx.y * margin;
    if (first < w.height && column < w.width + margin)
      codeUpright<kReach>(w, bin, column + threadIdx.x, first, threadIdx.x, threadIdx.y,
                          upright_words);
  }
}

template <class T>
void upload(const std::vector<T>& from, DeviceArray<T>* to) {
  to->resize(0);
  to->append(from.data(), from.size());
}

void copyRows(const uint8_t* from, size_t stride, const PictureWork& w, uint8_t* to) {
  const auto width = static_cast<size_t>(w.width);
  if (stride == width) {
    std::memcpy(to, from, pixelsOf(w));
    return;
  }
  for (int y = 0; y < w.height; ++y) std::memcpy(to + y * width, from + y * stride, width);
}

}  // namespace

void TableMaker::prepare(const TableRecipe& recipe) {
  recipe_ = nullptr;
  work_ = recipe.work;
  upload(recipe.directions, &directions_);
  upload(recipe.shifts, &shifts_);
  upload(recipe.level_codes, &level_codes_);
  upload(recipe.level_borders, &level_borders_);
  const size_t pixels = pixelsOf(work_), cells = cellsOf(work_);
  const auto bins = static_cast<size_t>(work_.bins);
  staging_.reserve(2 * pixels);
  picture_.resize(2 * pixels);
  gradients_.resize(3 * pixels);
  sampled_.resize(sampledOf(work_));
  const auto tiles = static_cast<size_t>(tilesOf(work_));
  sampled_count_.resize(tiles * kSquareLevels);
  limits_.resize(2);
  threshold_.resize(2 * tiles);
  parent_.resize(pixels);
  strong_.resize(pixels);
  matches_.resize(2 * pixels);
  count_.resize(bins * cells);
  usable_.resize(cells);
  level_.resize(bins * cells);
  codes_.resize(bins * pixels);
  PictureWork& w = work_;
  w.direction = directions_.data();
  w.shift = shifts_.data();
  w.level_codes = level_codes_.data();
  w.level_borders = level_borders_.data();
  w.grey = picture_.data();
  w.smooth = gradients_.data();
  w.gradient_x = gradients_.data() + pixels;
  w.gradient_y = gradients_.data() + 2 * pixels;
  w.sampled = sampled_.data();
  w.sampled_count = sampled_count_.data();
  w.limits = limits_.data();
  w.threshold = threshold_.data();
  w.parent = parent_.data();
  w.strong = strong_.data();
  w.match = matches_.data();
  w.hit = matches_.data() + pixels;
  w.count = count_.data();
  w.usable = usable_.data();
  w.level = level_.data();
  w.codes = codes_.data();
  reach_ = 0;
  for (const DirectionBin& d : recipe.directions) reach_ = std::max(reach_, reachOf(d.no_edge));
  finishCopies();
  recipe_ = &recipe;
}

void TableMaker::make(const TableRecipe& recipe, const PictureData& picture,
                      DeviceArray<Quad>* quads, cudaStream_t stream) {
  check(cudaEventSynchronize(copied_), "cudaEventSynchronize");
  if (recipe_ != &recipe) {
    check(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
    prepare(recipe);
  }
  PictureWork w = work_;
  const size_t pixels = pixelsOf(w);
  quads->resize(quadsOf(w));
  w.quads = quads->data();
  w.ignore = picture.ignore ? picture_.data() + pixels : nullptr;
  copyRows(picture.grey, picture.stride, w, staging_.data());
  if (picture.ignore) copyRows(picture.ignore, picture.ignore_stride, w, staging_.data() + pixels);
  check(cudaMemcpyAsync(picture_.data(), staging_.data(), (picture.ignore ? 2 : 1) * pixels,
                        cudaMemcpyHostToDevice, stream),
        "cudaMemcpyAsync of the picture");
  check(cudaEventRecord(copied_, stream), "cudaEventRecord");

  const dim3 block(kBlockX, kBlockY), per_pixel = blocksFor(w.width, w.height);
  smoothPixelKernel<<<per_pixel, block, 0, stream>>>(w);
  gradientOfPixelKernel<<<per_pixel, block, 0, stream>>>(w);
  selectLimitsKernel<<<1, kSelectThreads, 0, stream>>>(w, static_cast<uint32_t>(sampledOf(w)));
  setThresholdsKernel<<<tilesOf(w), kSquareLevels, 0, stream>>>(w);
  connectTileKernel<<<dim3((w.width + kTileX - 1) / kTileX, (w.height + kTileY - 1) / kTileY),
                      dim3(kTileX, kTileY), 0, stream>>>(w);
  connectBordersKernel<<<per_pixel, block, 0, stream>>>(w);
  markStrongKernel<<<per_pixel, block, 0, stream>>>(w);
  matchPixelKernel<<<per_pixel, block, 0, stream>>>(w);
  const dim3 per_cell = blocksFor(w.cell_columns, w.cell_rows);
  levelAndSlipKernel<<<per_cell.x * per_cell.y * w.bins + per_pixel.x * per_pixel.y, block, 0,
                       stream>>>(w, per_cell.x, per_cell.y, per_pixel.x);
  // The grid has enough blocks for both kinds of bins, walked by rows or by columns.
  const int margin = kTurnedWords * kWord;
  static_assert(kTurnedWords == kUprightWords);
  const dim3 code_grid(std::max((w.width + 2 * margin + kBlockX - 1) / kBlockX,
                                (w.height + 2 * margin + kBlockY - 1) / kBlockY),
                       (std::max(w.height, w.width) + margin - 1) / margin, w.bins);
  if (reach_ <= 1)
    codeKernel<1><<<code_grid, block, 0, stream>>>(w);
  else
    codeKernel<8><<<code_grid, block, 0, stream>>>(w);
  quadUpKernel<<<per_pixel, block, 0, stream>>>(w);
  check(cudaGetLastError(), "kernels of the table");
}

void TableMaker::convert(const Table& table, const uint16_t* pairs, DeviceArray<Quad>* quads,
                         cudaStream_t stream) {
  quads->resize(quadsOf(table));
  quadOfPairsKernel<<<blocksFor(table.width, table.height, table.bins), dim3(kBlockX, kBlockY), 0,
                      stream>>>(table, pairs, quads->data());
  check(cudaGetLastError(), "kernel of the table");
}

size_t TableMaker::bytes() const {
  return directions_.bytes() + shifts_.bytes() + threshold_.bytes() + parent_.bytes() +
         level_codes_.bytes() + picture_.bytes() + strong_.bytes() + level_.bytes() +
         codes_.bytes() + level_borders_.bytes() + count_.bytes() + usable_.bytes() +
         gradients_.bytes() + sampled_.bytes() + sampled_count_.bytes() + limits_.bytes() +
         matches_.bytes();
}

}  // namespace edge_mcl::gpu
