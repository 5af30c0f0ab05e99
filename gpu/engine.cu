#include "engine.h"

#include <cuda_runtime.h>

#include <array>
#include <cstring>

#include "device_memory.h"

namespace edge_mcl::gpu {

namespace {

constexpr int kBlockThreads = 128;
constexpr unsigned kTeamMask = 0xffffu;

/// What the kernel reads besides the particles; passed by value, so that it lies in constant
/// memory.
struct Scene {
  Camera camera;
  Table table;
  Rule rule;
  Combination combination;
  const uint16_t* pairs;
  const float* along;
  const Segment* segments;
  const uint32_t* group_ends;
  const Cell* cells;
};

/// The same on all lanes of a team; the order of additions is fixed.
__device__ float sumOfTeam(float value, unsigned mask) {
  for (int step = kTeamLanes / 2; step > 0; step /= 2)
    value += __shfl_xor_sync(mask, value, step, kTeamLanes);
  return value;
}

/// kTeams teams of sixteen lanes for every particle, several particles to a block.
template <int kTeams>
__global__ void __launch_bounds__(kBlockThreads)
    scoreKernel(const Scene scene, const Particle* __restrict__ particles, uint32_t count,
                Result* __restrict__ results) {
  constexpr int kLanes = kTeams * kTeamLanes, kParticles = kBlockThreads / kLanes;
  __shared__ Pose poses[kParticles];
  __shared__ LineSums sums[kParticles * kTeams];
  const int slot = threadIdx.x / kLanes, lane_of_particle = threadIdx.x % kLanes;
  const int team = lane_of_particle / kTeamLanes, lane = lane_of_particle % kTeamLanes;
  const uint32_t number = blockIdx.x * kParticles + slot;
  const bool active = number < count;
  const uint32_t particle = active ? number : count - 1;
  const Cell cell = scene.cells[particles[particle].cell];
  if (lane_of_particle < 12) fillPose(particles[particle], cell, lane_of_particle, &poses[slot]);
  __syncthreads();

  const Pose& pose = poses[slot];
  const unsigned mask = kTeamMask << (threadIdx.x % 32 / kTeamLanes * kTeamLanes);
  const uint32_t* ends = scene.group_ends + cell.first_group;
  const Segment* segments = scene.segments + cell.first_segment;
  LineSums own{0, 0, 0, 0};
  for (uint32_t g = team; g < cell.group_count; g += kTeams) {
    PartialLine line{0, 0};
    for (uint32_t s = g == 0 ? 0 : ends[g - 1]; s < ends[g]; ++s)
      addSample(scene.camera, scene.table, scene.pairs, scene.rule, pose, segments[s], scene.along,
                lane, &line);
    line.score = sumOfTeam(line.score, mask);
    line.weight = sumOfTeam(line.weight, mask);
    closeLine(scene.rule, line, &own);
  }
  if (lane == 0) sums[slot * kTeams + team] = own;
  __syncthreads();
  if (active && lane_of_particle == 0)
    results[particle] = combineTeams(scene.rule, scene.combination, &sums[slot * kTeams], kTeams);
}

template <int kTeams>
void launch(const Scene& scene, const Particle* particles, uint32_t count, Result* results,
            cudaStream_t stream) {
  constexpr uint32_t kParticles = kBlockThreads / (kTeams * kTeamLanes);
  scoreKernel<kTeams><<<(count + kParticles - 1) / kParticles, kBlockThreads, 0, stream>>>(
      scene, particles, count, results);
  check(cudaGetLastError(), "scoreKernel");
}

}  // namespace

struct Engine::Impl {
  cudaDeviceProp properties{};
  Stream work, copy;
  Event kernel_begin, kernel_end;
  DeviceArray<float> along;
  DeviceArray<Segment> segments;
  DeviceArray<uint32_t> group_ends;
  DeviceArray<Cell> cells;
  DeviceArray<Particle> particles;
  DeviceArray<Result> results;
  PinnedArray<Particle> particles_staging;
  PinnedArray<Result> results_staging;
  /// Two tables: one is read while the other is filled.
  struct ImageSlot {
    DeviceArray<uint16_t> pairs;
    PinnedArray<uint16_t> staging;
    Event copied;  // staging may be written again
  };
  std::array<ImageSlot, 2> slots;
  int current = 0;
  Scene scene{};
  bool has_image = false;
  float kernel_ms = 0;
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
  check(cudaGetDeviceProperties(&impl_->properties, device), "cudaGetDeviceProperties");
}

Engine::~Engine() = default;

std::string Engine::deviceName() const {
  const cudaDeviceProp& p = impl_->properties;
  return std::string(p.name) + ", compute capability " + std::to_string(p.major) + "." +
         std::to_string(p.minor);
}

size_t Engine::deviceBytes() const {
  const Impl& m = *impl_;
  return m.along.bytes() + m.segments.bytes() + m.group_ends.bytes() + m.cells.bytes() +
         m.particles.bytes() + m.results.bytes() + m.slots[0].pairs.bytes() +
         m.slots[1].pairs.bytes();
}

void Engine::setModel(const float* along, size_t count) {
  impl_->along.resize(0);
  impl_->along.append(along, count);
  clearCells();
}

uint32_t Engine::addCell(Cell cell, const Segment* segments, size_t segment_count,
                         const uint32_t* group_ends, size_t group_count) {
  Impl& m = *impl_;
  cell.first_segment = static_cast<uint32_t>(m.segments.size());
  cell.first_group = static_cast<uint32_t>(m.group_ends.size());
  cell.group_count = static_cast<uint32_t>(group_count);
  m.segments.append(segments, segment_count);
  m.group_ends.append(group_ends, group_count);
  m.cells.append(&cell, 1);
  return static_cast<uint32_t>(m.cells.size() - 1);
}

size_t Engine::cellCount() const { return impl_->cells.size(); }

void Engine::clearCells() {
  impl_->segments.resize(0);
  impl_->group_ends.resize(0);
  impl_->cells.resize(0);
}

void Engine::setImage(const Camera& camera, const Table& table, const uint16_t* pairs,
                      size_t count) {
  Impl& m = *impl_;
  m.current = 1 - m.current;
  Impl::ImageSlot& slot = m.slots[m.current];
  check(cudaEventSynchronize(slot.copied), "cudaEventSynchronize");
  slot.staging.reserve(count);
  slot.pairs.resize(count);
  std::memcpy(slot.staging.data(), pairs, count * sizeof *pairs);
  check(cudaMemcpyAsync(slot.pairs.data(), slot.staging.data(), count * sizeof *pairs,
                        cudaMemcpyHostToDevice, m.copy),
        "cudaMemcpyAsync of the table");
  check(cudaEventRecord(slot.copied, m.copy), "cudaEventRecord");
  m.scene.camera = camera;
  m.scene.table = table;
  m.scene.pairs = slot.pairs.data();
  m.has_image = true;
}

void Engine::score(const Rule& rule, const Combination& combination, const Particle* particles,
                   size_t count, Result* results) {
  Impl& m = *impl_;
  if (count == 0) return;
  if (!m.has_image) throw DeviceError("CUDA: score before setImage");
  for (size_t i = 0; i < count; ++i)
    if (particles[i].cell >= m.cells.size()) throw DeviceError("CUDA: particle in no known cell");
  m.particles_staging.reserve(count);
  m.results_staging.reserve(count);
  m.particles.resize(count);
  m.results.resize(count);
  std::memcpy(m.particles_staging.data(), particles, count * sizeof *particles);
  check(cudaMemcpyAsync(m.particles.data(), m.particles_staging.data(), count * sizeof *particles,
                        cudaMemcpyHostToDevice, m.work),
        "cudaMemcpyAsync of the particles");
  check(cudaStreamWaitEvent(m.work, m.slots[m.current].copied, 0), "cudaStreamWaitEvent");
  m.scene.rule = rule;
  m.scene.combination = combination;
  m.scene.along = m.along.data();
  m.scene.segments = m.segments.data();
  m.scene.group_ends = m.group_ends.data();
  m.scene.cells = m.cells.data();
  check(cudaEventRecord(m.kernel_begin, m.work), "cudaEventRecord");
  const auto n = static_cast<uint32_t>(count);
  if (teamsFor(count) == 8)
    launch<8>(m.scene, m.particles.data(), n, m.results.data(), m.work);
  else
    launch<2>(m.scene, m.particles.data(), n, m.results.data(), m.work);
  check(cudaEventRecord(m.kernel_end, m.work), "cudaEventRecord");
  check(cudaMemcpyAsync(m.results_staging.data(), m.results.data(), count * sizeof *results,
                        cudaMemcpyDeviceToHost, m.work),
        "cudaMemcpyAsync of the results");
  check(cudaStreamSynchronize(m.work), "scoreKernel");
  check(cudaEventElapsedTime(&m.kernel_ms, m.kernel_begin, m.kernel_end), "cudaEventElapsedTime");
  std::memcpy(results, m.results_staging.data(), count * sizeof *results);
}

DeviceLimits Engine::limits() const {
  const cudaDeviceProp& p = impl_->properties;
  int device = 0, clock_khz = 0, memory_khz = 0;
  check(cudaGetDevice(&device), "cudaGetDevice");
  check(cudaDeviceGetAttribute(&clock_khz, cudaDevAttrClockRate, device), "cudaDeviceGetAttribute");
  check(cudaDeviceGetAttribute(&memory_khz, cudaDevAttrMemoryClockRate, device),
        "cudaDeviceGetAttribute");
  // CUDA C++ Programming Guide, "Arithmetic Instructions": 128 a clock, 64 on 7.5 and 8.0.
  const bool narrow = p.major == 7 || (p.major == 8 && p.minor == 0);
  return {1e3 * clock_khz * p.multiProcessorCount * (narrow ? 64 : 128),
          2e3 * memory_khz * p.memoryBusWidth / 8};
}

float Engine::kernelMilliseconds() const { return impl_->kernel_ms; }

}  // namespace edge_mcl::gpu
