#include "edge_mcl/gpu/engine/engine.h"

#include <cuda_runtime.h>

#include <array>
#include <cstring>

#include "edge_mcl/gpu/engine/device_memory.h"
#include "edge_mcl/gpu/engine/table_maker.h"

namespace edge_mcl::gpu {

namespace {

constexpr int kBlockThreads = kParts * kLanes;
constexpr unsigned kAll = 0xffffffffu;

/// Data that the kernel reads besides the particles. They are passed by value, so that they lie in
/// constant memory.
struct Scene {
  Camera camera;
  Table table;
  Rule rule;
  Combination combination;
  const Quad* quads;
  const Chunk* chunks;
  const Sample* samples;
  const Cell* cells;
};

/// Loads 32 bytes with two loads of 16 bytes, because the compiler does not combine the loads
/// itself.
template <class T>
__device__ T load32(const T* from) {
  static_assert(sizeof(T) == 32);
  union {
    float4 half[2];
    T whole;
  } value;
  value.half[0] = __ldg(reinterpret_cast<const float4*>(from));
  value.half[1] = __ldg(reinterpret_cast<const float4*>(from) + 1);
  return value.whole;
}

/// Returns, for every lane, the sum over the lanes from `start` to this lane.
__device__ PartialLine sumOfLine(PartialLine own, int lane, int start) {
  for (int step = 1; step < kLanes; step *= 2) {
    const float score = __shfl_up_sync(kAll, own.score, step);
    const float weight = __shfl_up_sync(kAll, own.weight, step);
    if (lane - step >= start) {
      own.score += score;
      own.weight += weight;
    }
  }
  return own;
}

/// Scores the samples of a chunk, one per lane, and closes the lines that end in it. The last line
/// stays open. The order of additions is fixed.
__device__ void scoreChunk(const Scene& scene, const Pose& pose, uint32_t number, int lane,
                           OpenLine* open, LineSums* own) {
  const Chunk chunk = load32(scene.chunks + number);
  PartialLine line{0, 0};
  if (lane < static_cast<int>(chunk.count))
    line = scoreOf(scene.camera, scene.table, scene.quads, scene.rule, pose,
                   load32(scene.samples + static_cast<size_t>(number) * kLanes + lane));
  if (!__any_sync(kAll, line.weight > 0)) return;
  const unsigned heads = chunk.heads | 1u;
  const int start = kLanes - 1 - __clz(heads & (kAll >> (kLanes - 1 - lane)));
  line = sumOfLine(line, lane, start);
  if (open->line == chunk.first_line) {
    if (start == 0) {
      line.score += open->sum.score;
      line.weight += open->sum.weight;
    }
  } else if (lane == 0 && open->line != kNoLine) {
    closeLine(scene.rule, open->sum, own);
  }
  if (lane < kLanes - 1 && (heads >> (lane + 1) & 1u)) closeLine(scene.rule, line, own);
  open->sum.score = __shfl_sync(kAll, line.score, kLanes - 1);
  open->sum.weight = __shfl_sync(kAll, line.weight, kLanes - 1);
  open->line = chunk.last_line;
}

__device__ void scorePart(const Scene& scene, const Cell& cell, int part, const Pose& pose,
                          int lane, LineSums* own) {
  OpenLine open{{0, 0}, kNoLine};
  const uint32_t end = cell.part_end[part];
  for (uint32_t base = part == 0 ? 0 : cell.part_end[part - 1]; base < end; base += kLanes) {
    // Every lane checks whether one chunk is in view.
    const uint32_t mine = base + lane;
    const bool seen = mine < end && mayBeInView(scene.camera, pose,
                                                load32(scene.chunks + cell.first_chunk + mine));
    for (unsigned left = __ballot_sync(kAll, seen); left != 0; left &= left - 1)
      scoreChunk(scene, pose, cell.first_chunk + base + __ffs(left) - 1, lane, &open, own);
  }
  if (lane == 0 && open.line != kNoLine) closeLine(scene.rule, open.sum, own);
}

/// Returns the sum over all lanes, on every lane. The order of additions is fixed.
template <class T>
__device__ T sumOfLanes(T value) {
  for (int step = kLanes / 2; step > 0; step /= 2) value += __shfl_xor_sync(kAll, value, step);
  return value;
}

struct PartSums {
  double sum;
  float lines, weight;
};

/// Scores particles with blocks of kParts warps. With kWarps = kParts a block has one particle, and
/// every warp has one part of its lines. With kWarps = 1 a block has kParts particles, one per
/// warp.
template <int kWarps>
__global__ void __launch_bounds__(kBlockThreads)
    scoreKernel(const Scene scene, const Particle* __restrict__ particles, uint32_t count,
                Result* __restrict__ results) {
  static_assert(kWarps == 1 || kWarps == kParts);
  constexpr int kParticles = kParts / kWarps;
  __shared__ Pose poses[kParticles];
  __shared__ PartSums parts[kParts];
  const int warp = threadIdx.x / kLanes, lane = threadIdx.x % kLanes;
  const int slot = kWarps == 1 ? warp : 0;
  const uint32_t number = blockIdx.x * kParticles + slot;
  const uint32_t particle = number < count ? number : count - 1;
  const Cell& cell = scene.cells[particles[particle].cell];
  if (lane < 12 && (kWarps == 1 || warp == 0))
    fillPose(particles[particle], cell, lane, &poses[slot]);
  __syncthreads();
  const Pose pose = poses[slot];
  LineSums own{0, 0, 0, 0};
  if (kWarps == 1) {
    for (int part = 0; part < kParts; ++part) scorePart(scene, cell, part, pose, lane, &own);
  } else {
    scorePart(scene, cell, warp, pose, lane, &own);
  }
  PartSums sums{sumOfLanes(static_cast<double>(own.sum) + own.error), sumOfLanes(own.count),
                sumOfLanes(own.weight)};
  if (kWarps > 1) {
    if (lane == 0) parts[warp] = sums;
    __syncthreads();
    sums = parts[0];
    for (int w = 1; w < kWarps; ++w) {
      sums.sum += parts[w].sum;
      sums.lines += parts[w].lines;
      sums.weight += parts[w].weight;
    }
  }
  if (number < count && lane == 0 && (kWarps == 1 || warp == 0))
    results[number] = combine(scene.rule, scene.combination, sums.sum, sums.lines, sums.weight);
}

template <int kWarps>
void launch(const Scene& scene, const Particle* particles, uint32_t count, Result* results,
            cudaStream_t stream) {
  constexpr uint32_t kParticles = kParts / kWarps;
  scoreKernel<kWarps><<<(count + kParticles - 1) / kParticles, kBlockThreads, 0, stream>>>(
      scene, particles, count, results);
  check(cudaGetLastError(), "scoreKernel");
}

/// A table on the device with its camera and its buffers.
struct Image {
  Camera camera{};
  Table table{};
  DeviceArray<Quad> quads;
  DeviceArray<uint16_t> pairs;  ///< table as the host made it
  PinnedArray<uint16_t> staging;
  Event ready;
  bool filled = false;
};

}  // namespace

struct Engine::Impl {
  cudaDeviceProp properties{};
  Stream work, second, images;
  Event kernel_begin, kernel_end, picture_begin, picture_end;
  DeviceArray<Chunk> chunks;
  DeviceArray<Sample> samples;
  DeviceArray<Cell> cells;
  DeviceArray<Particle> particles;
  DeviceArray<Result> results;
  PinnedArray<Particle> particles_staging;
  PinnedArray<Result> results_staging;
  size_t count = 0, submissions = 0;
  std::array<Image, kImages> image;
  TableMaker maker;

  Image& imageAt(int i) {
    if (i < 0 || i >= kImages) throw DeviceError("CUDA: no such image");
    return image[i];
  }
};

std::string Engine::whyUnavailable() {
  int count = 0;
  const cudaError_t status = cudaGetDeviceCount(&count);
  if (status != cudaSuccess) return cudaGetErrorString(status);
  return count > 0 ? "" : "no CUDA device";
}

Engine::Engine() {
  if (const std::string why = whyUnavailable(); !why.empty()) throw DeviceError("CUDA: " + why);
  impl_ = std::make_unique<Impl>();
  int device = 0;
  check(cudaGetDevice(&device), "cudaGetDevice");
  const cudaDeviceProp& p = impl_->properties;
  check(cudaGetDeviceProperties(&impl_->properties, device), "cudaGetDeviceProperties");
  if (p.major * 10 + p.minor < 75)
    throw DeviceError("CUDA: " + deviceName() + ", at least 7.5 is needed");
}

Engine::~Engine() {
  if (impl_) cudaDeviceSynchronize();  // no kernel may still use the memory
}

std::string Engine::deviceName() const {
  const cudaDeviceProp& p = impl_->properties;
  return std::string(p.name) + ", compute capability " + std::to_string(p.major) + "." +
         std::to_string(p.minor);
}

size_t Engine::deviceBytes() const {
  const Impl& m = *impl_;
  size_t bytes = m.chunks.bytes() + m.samples.bytes() + m.cells.bytes() + m.particles.bytes() +
                 m.results.bytes() + m.maker.bytes();
  for (const Image& image : m.image) bytes += image.quads.bytes() + image.pairs.bytes();
  return bytes;
}

size_t Engine::freeBytes() {
  size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return free;
}

uint32_t Engine::addCell(Cell cell, const Chunk* chunks, const Sample* samples) {
  Impl& m = *impl_;
  cell.first_chunk = static_cast<uint32_t>(m.chunks.size());
  m.chunks.append(chunks, cell.chunk_count);
  m.samples.append(samples, static_cast<size_t>(cell.chunk_count) * kLanes);
  m.cells.append(&cell, 1);
  finishCopies();
  return static_cast<uint32_t>(m.cells.size() - 1);
}

void Engine::clearCells() {
  impl_->chunks.resize(0);
  impl_->samples.resize(0);
  impl_->cells.resize(0);
}

void Engine::setTable(int image, const Camera& camera, const Table& table, const uint16_t* pairs,
                      size_t count) {
  Impl& m = *impl_;
  Image& i = m.imageAt(image);
  check(cudaEventSynchronize(i.ready), "cudaEventSynchronize");
  i.staging.reserve(count);
  i.pairs.resize(count);
  std::memcpy(i.staging.data(), pairs, count * sizeof *pairs);
  check(cudaMemcpyAsync(i.pairs.data(), i.staging.data(), count * sizeof *pairs,
                        cudaMemcpyHostToDevice, m.images),
        "cudaMemcpyAsync of the table");
  TableMaker::convert(table, i.pairs.data(), &i.quads, m.images);
  check(cudaEventRecord(i.ready, m.images), "cudaEventRecord");
  i.camera = camera;
  i.table = table;
  i.filled = true;
}

void Engine::setPicture(int image, const Camera& camera, const Table& table,
                        const TableRecipe& recipe, const PictureData& picture) {
  Impl& m = *impl_;
  Image& i = m.imageAt(image);
  i.filled = false;
  check(cudaEventRecord(m.picture_begin, m.images), "cudaEventRecord");
  m.maker.make(recipe, picture, &i.quads, m.images);
  check(cudaEventRecord(m.picture_end, m.images), "cudaEventRecord");
  check(cudaEventRecord(i.ready, m.images), "cudaEventRecord");
  i.camera = camera;
  i.table = table;
  i.filled = true;
}

Particle* Engine::particles(size_t count) {
  Impl& m = *impl_;
  wait();  // a caller may have stopped after submit() because of an error
  m.particles_staging.reserve(count);
  m.results_staging.reserve(count);
  m.particles.resize(count);
  m.results.resize(count);
  m.count = count;
  m.submissions = 0;
  return m.particles_staging.data();
}

void Engine::submit(int image, const Rule& rule, const Combination& combination, size_t first,
                    size_t count) {
  Impl& m = *impl_;
  Image& i = m.imageAt(image);
  if (count == 0) return;
  if (!i.filled) throw DeviceError("CUDA: no such table");
  if (first + count > m.count) throw DeviceError("CUDA: no such particles");
  // Two streams take turns, so that the copies of one overlap with the kernel of the other.
  const cudaStream_t stream = m.submissions++ % 2 == 0 ? m.work : m.second;
  check(cudaMemcpyAsync(m.particles.data() + first, m.particles_staging.data() + first,
                        count * sizeof(Particle), cudaMemcpyHostToDevice, stream),
        "cudaMemcpyAsync of the particles");
  check(cudaStreamWaitEvent(stream, i.ready, 0), "cudaStreamWaitEvent");
  const Scene scene{i.camera,        i.table,          rule,          combination, i.quads.data(),
                    m.chunks.data(), m.samples.data(), m.cells.data()};
  check(cudaEventRecord(m.kernel_begin, stream), "cudaEventRecord");
  const auto n = static_cast<uint32_t>(count);
  if (warpsFor(m.count) == kParts)
    launch<kParts>(scene, m.particles.data() + first, n, m.results.data() + first, stream);
  else
    launch<1>(scene, m.particles.data() + first, n, m.results.data() + first, stream);
  check(cudaEventRecord(m.kernel_end, stream), "cudaEventRecord");
  check(cudaMemcpyAsync(m.results_staging.data() + first, m.results.data() + first,
                        count * sizeof(Result), cudaMemcpyDeviceToHost, stream),
        "cudaMemcpyAsync of the results");
}

const Result* Engine::wait() {
  Impl& m = *impl_;
  check(cudaStreamSynchronize(m.work), "scoreKernel");
  if (m.submissions > 1) check(cudaStreamSynchronize(m.second), "scoreKernel");
  return m.results_staging.data();
}

std::vector<Quad> Engine::table(int image) {
  Image& i = impl_->imageAt(image);
  check(cudaEventSynchronize(i.ready), "kernels of the table");
  std::vector<Quad> quads(i.filled ? i.quads.size() : 0);
  if (!quads.empty())
    check(cudaMemcpy(quads.data(), i.quads.data(), quads.size() * sizeof quads[0],
                     cudaMemcpyDeviceToHost),
          "cudaMemcpy of the table");
  return quads;
}

DeviceLimits Engine::limits() const {
  const cudaDeviceProp& p = impl_->properties;
  int device = 0, clock_khz = 0, memory_khz = 0;
  check(cudaGetDevice(&device), "cudaGetDevice");
  check(cudaDeviceGetAttribute(&clock_khz, cudaDevAttrClockRate, device), "cudaDeviceGetAttribute");
  check(cudaDeviceGetAttribute(&memory_khz, cudaDevAttrMemoryClockRate, device),
        "cudaDeviceGetAttribute");
  // CUDA C++ Programming Guide, "Arithmetic Instructions": 128 operations per clock cycle and
  // multiprocessor, 64 on compute capability 7.5 and 8.0.
  const bool narrow = p.major == 7 || (p.major == 8 && p.minor == 0);
  return {1e3 * clock_khz * p.multiProcessorCount * (narrow ? 64 : 128),
          2e3 * memory_khz * p.memoryBusWidth / 8};
}

namespace {

float millisecondsBetween(cudaEvent_t begin, cudaEvent_t end) {
  float ms = 0;
  check(cudaEventSynchronize(end), "cudaEventSynchronize");
  check(cudaEventElapsedTime(&ms, begin, end), "cudaEventElapsedTime");
  return ms;
}

}  // namespace

float Engine::kernelMilliseconds() const {
  return millisecondsBetween(impl_->kernel_begin, impl_->kernel_end);
}

float Engine::pictureMilliseconds() const {
  return millisecondsBetween(impl_->picture_begin, impl_->picture_end);
}

}  // namespace edge_mcl::gpu
