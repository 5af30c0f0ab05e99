/// Computes the thresholds of the image edges from the gradients, on the device.
#pragma once

#include "edge_mcl/gpu/math/picture_math.h"

namespace edge_mcl::gpu {

namespace {

// The order statistics of the squared magnitudes are found digit by digit with histograms. The
// first digit is logarithmic, because most magnitudes are small.

constexpr int kWarpLanes = 32, kSelectThreads = 1024, kHistogram = 2048, kDigitBits = 11;

/// Returns the number of bits of a value that lie below its first digit. The digit holds the
/// leading bit and the six bits after it.
__device__ int lowBits(uint32_t value) {
  const int bits = 32 - __clz(value);
  return bits > 7 ? bits - 7 : 0;
}

__device__ uint32_t firstDigit(uint32_t value) {
  const int low = lowBits(value);
  return (static_cast<uint32_t>(low) << 6) + (value >> low);
}

/// An order statistic that is partly known: its leading bits, down to bit `low`.
struct Selection {
  uint32_t prefix, rank;  // rank among the values with this prefix
  int low;
};

constexpr int kShare = kHistogram / kWarpLanes;  ///< number of digits that a lane adds up

/// Returns the place of a digit in the histogram. One element is left out after every kShare
/// digits, so that the lanes read their shares from different memory banks.
__device__ uint32_t placeOf(uint32_t digit) { return digit + digit / kShare; }
constexpr int kPlaces = kHistogram + kWarpLanes;

/// Returns, for every lane, the sum over the lanes up to this lane.
__device__ uint32_t sumUpTo(uint32_t value, int lane) {
  for (int step = 1; step < kWarpLanes; step *= 2) {
    const uint32_t before = __shfl_up_sync(0xffffffffu, value, step);
    if (lane >= step) value += before;
  }
  return value;
}

/// Finds the digit that holds the rank. All lanes of one warp must call it. `rank` becomes the rank
/// within this digit.
__device__ uint32_t findDigit(const uint32_t* histogram, uint32_t* rank) {
  const int lane = threadIdx.x % kWarpLanes;
  uint32_t own = 0;
#pragma unroll 16
  for (int i = 0; i < kShare; ++i) own += histogram[lane * (kShare + 1) + i];
  const uint32_t up_to = sumUpTo(own, lane);
  const int holder = __ffs(__ballot_sync(0xffffffffu, up_to > *rank)) - 1;
  const uint32_t rest = *rank - __shfl_sync(0xffffffffu, up_to - own, holder);
  // Every lane has two digits of the holder's share.
  static_assert(kShare == 2 * kWarpLanes);
  const uint32_t* two = histogram + holder * (kShare + 1) + 2 * lane;
  const uint32_t low = two[0], both = low + two[1], before = sumUpTo(both, lane) - both;
  const int finder = __ffs(__ballot_sync(0xffffffffu, before + both > rest)) - 1;
  const bool second = rest >= before + low;
  const uint32_t digit = holder * kShare + 2 * lane + second;
  *rank = __shfl_sync(0xffffffffu, rest - before - (second ? low : 0), finder);
  return __shfl_sync(0xffffffffu, digit, finder);
}

/// Number of values that a thread keeps in registers; enough for 640 x 480 pixels.
constexpr int kKept = 34;

/// Counts a digit of every valid lane. In flat images all lanes have the same digit, which is then
/// added in one step. (Joining equal lanes with __match_any_sync takes longer than it saves.)
__device__ void countDigit(uint32_t* histogram, uint32_t digit, bool valid) {
  const unsigned lanes = __ballot_sync(0xffffffffu, valid);
  if (lanes == 0) return;
  const int leader = __ffs(static_cast<int>(lanes)) - 1;
  const uint32_t first = __shfl_sync(0xffffffffu, digit, leader);
  if (__all_sync(0xffffffffu, !valid || digit == first)) {
    if (static_cast<int>(threadIdx.x % kWarpLanes) == leader)
      atomicAdd(&histogram[placeOf(first)], static_cast<uint32_t>(__popc(lanes)));
  } else if (valid) {
    atomicAdd(&histogram[placeOf(digit)], 1u);
  }
}

/// Calls `use` for every sampled magnitude. All threads call it the same number of times.
template <class F>
__device__ void forSamples(const uint32_t (&kept)[kKept], const uint32_t* sampled, uint32_t samples,
                           F&& use) {
#pragma unroll
  for (int k = 0; k < kKept; ++k) use(kept[k]);
  for (uint32_t base = kKept * kSelectThreads; base < samples; base += kSelectThreads) {
    const uint32_t i = base + threadIdx.x;
    use(i < samples ? sampled[i] : kIgnoredSample);
  }
}

__device__ void clearHistograms(uint32_t (*histogram)[kPlaces]) {
  for (int i = threadIdx.x; i < 2 * kPlaces; i += kSelectThreads)
    histogram[i / kPlaces][i % kPlaces] = 0;
}

__global__ void __launch_bounds__(kSelectThreads)
    selectLimitsKernel(const PictureWork w, uint32_t samples) {
  __shared__ uint32_t histogram[2][kPlaces];
  __shared__ Selection selection[2];
  __shared__ uint32_t count;
  const int warp = threadIdx.x / kWarpLanes, lane = threadIdx.x % kWarpLanes;
  uint32_t kept[kKept];
#pragma unroll
  for (int k = 0; k < kKept; ++k) {
    const uint32_t i = k * kSelectThreads + threadIdx.x;
    kept[k] = i < samples ? w.sampled[i] : kIgnoredSample;
  }
  clearHistograms(histogram);
  if (threadIdx.x == 0) count = 0;
  __syncthreads();
  uint32_t own = 0;
  forSamples(kept, w.sampled, samples, [&](uint32_t value) {
    const bool valid = value != kIgnoredSample;
    own += valid;
    countDigit(histogram[0], valid ? firstDigit(value) : 0, valid);
  });
  if (own > 0) atomicAdd(&count, own);
  __syncthreads();
  if (count == 0) {
    if (threadIdx.x == 0) setLimits(w, 0, 0, 0);
    return;
  }
  const QuantileRanks ranks = quantileRanks(w, count);
  if (warp < 2) {
    uint32_t rank = warp == 0 ? ranks.noise : ranks.edges;
    const uint32_t digit = findDigit(histogram[0], &rank);
    // Digits below 128 are the values themselves. Above, every number of low bits has 64 digits.
    const int low = digit < 128 ? 0 : static_cast<int>(digit / 64) - 1;
    if (lane == 0) selection[warp] = {digit < 128 ? digit : digit - 64u * low, rank, low};
  }
  __syncthreads();
  while (selection[0].low > 0 || selection[1].low > 0) {
    const Selection known[2] = {selection[0], selection[1]};
    clearHistograms(histogram);
    __syncthreads();
    forSamples(kept, w.sampled, samples, [&](uint32_t value) {
      for (int q = 0; q < 2; ++q) {
        if (value == kIgnoredSample || known[q].low == 0 ||
            value >> known[q].low != known[q].prefix)
          continue;
        const int next = max(0, known[q].low - kDigitBits);
        const uint32_t digit = (value >> next) - (known[q].prefix << (known[q].low - next));
        atomicAdd(&histogram[q][placeOf(digit)], 1u);
      }
    });
    __syncthreads();
    if (warp < 2 && known[warp].low > 0) {
      uint32_t rank = known[warp].rank;
      const uint32_t digit = findDigit(histogram[warp], &rank);
      const int next = max(0, known[warp].low - kDigitBits);
      if (lane == 0)
        selection[warp] = {(known[warp].prefix << (known[warp].low - next)) + digit, rank, next};
    }
    __syncthreads();
  }
  if (threadIdx.x == 0) setLimits(w, count, selection[0].prefix, selection[1].prefix);
}

/// Sets the thresholds of the tiles, a block for every tile.
__global__ void __launch_bounds__(kSquareLevels) setThresholdsKernel(const PictureWork w) {
  __shared__ int32_t around[kSquareLevels];
  const int tile = blockIdx.x, level = threadIdx.x;
  if (w.tile > 0)
    around[level] = samplesAround(w, tile % w.tile_columns, tile / w.tile_columns, level);
  __syncthreads();
  if (level == 0) setThresholds(w, tile, w.tile > 0 ? around : nullptr);
}

}  // namespace

}  // namespace edge_mcl::gpu
