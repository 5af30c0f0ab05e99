// edge_mcl_gpu_check: a workload file through the device (parity, time) or through the host
// emulation.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "engine.h"
#include "host_emulation.h"
#include "workload.h"

namespace {

using namespace edge_mcl::gpu;

constexpr int kOk = 0, kWrong = 1, kUsage = 2, kBroken = 3, kSkipped = 77;
/// Allowed difference of log-likelihoods. Single precision places a sample to some 3e-5 pixels and
/// a score changes by up to 5 per pixel; discounts bring the sum's error below this.
constexpr double kTolerance = 1e-3;

struct Agreement {
  double largest = 0;
  size_t swapped =
      0;  ///< of the best 100 of one side, those whose rank differs beyond the tolerance
};

std::vector<uint32_t> ranking(const std::vector<double>& values) {
  std::vector<uint32_t> order(values.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return values[a] > values[b]; });
  return order;
}

Agreement compare(const std::vector<double>& reference, const std::vector<Result>& results) {
  Agreement a;
  std::vector<double> values;
  values.reserve(results.size());
  for (const Result& r : results) values.push_back(r.log_likelihood);
  for (size_t i = 0; i < values.size(); ++i) {
    const double difference = std::abs(values[i] - reference[i]);
    a.largest = std::isfinite(difference) ? std::max(a.largest, difference) : HUGE_VAL;
  }
  const std::vector<uint32_t> by_reference = ranking(reference), by_value = ranking(values);
  for (size_t k = 0; k < std::min<size_t>(100, values.size()); ++k)
    if (std::abs(reference[by_reference[k]] - reference[by_value[k]]) > kTolerance) ++a.swapped;
  return a;
}

bool report(const char* what, const Workload& w, const std::vector<Result>& results) {
  const Agreement a = compare(w.reference, results);
  const bool good = a.largest <= kTolerance && a.swapped == 0;
  std::printf("%s: %zu particles, largest difference %.2g, %zu of the best 100 out of rank: %s\n",
              what, results.size(), a.largest, a.swapped, good ? "ok" : "WRONG");
  return good;
}

void load(const Workload& w, Engine* engine) {
  engine->setModel(w.along.data(), w.along.size());
  for (const Cell& c : w.cells) {
    const uint32_t* ends = w.group_ends.data() + c.first_group;
    engine->addCell(c, w.segments.data() + c.first_segment,
                    c.group_count ? ends[c.group_count - 1] : 0, ends, c.group_count);
  }
}

double medianMilliseconds(int repeats, const std::function<void()>& work) {
  std::vector<double> ms;
  ms.reserve(repeats);
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                     .count());
  }
  std::nth_element(ms.begin(), ms.begin() + repeats / 2, ms.end());
  return ms[repeats / 2];
}

/// Visible samples of the particles' cells, after thinning: what the kernel works through.
double samplesPerParticle(const Workload& w) {
  std::vector<double> of_cell(w.cells.size(), 0);
  for (size_t c = 0; c < w.cells.size(); ++c) {
    const Cell& cell = w.cells[c];
    if (cell.group_count == 0) continue;
    const uint32_t count = w.group_ends[cell.first_group + cell.group_count - 1];
    for (uint32_t s = cell.first_segment; s < cell.first_segment + count; ++s)
      for (int lane = 0; lane < kTeamLanes; ++lane)
        of_cell[c] += isUsed(w.rule, w.segments[s], lane);
  }
  double sum = 0;
  for (const Particle& p : w.particles) sum += of_cell[p.cell];
  return sum / static_cast<double>(w.particles.size());
}

/// How far the largest run was from what the device can do at best.
void printRoofline(const Engine& engine, double samples, double kernel_ms) {
  // Counted in scoreSample: arithmetic of a sample without distortion, and its two look-ups, which
  // are charged as if they all went to memory in sectors of 32 bytes.
  constexpr double kOperations = 110, kBytes = 2 * 32;
  const DeviceLimits limits = engine.limits();
  const double per_second = samples / (1e-3 * kernel_ms);
  const double arithmetic = per_second * kOperations / limits.operations_per_second;
  const double memory = per_second * kBytes / limits.memory_bytes_per_second;
  std::printf(
      "roofline: %.1f G samples/s; %.0f %% of the arithmetic limit, %.0f %% of the memory "
      "limit if every look-up missed the caches; nearer to %s\n",
      1e-9 * per_second, 100 * arithmetic, 100 * memory,
      arithmetic > memory ? "arithmetic" : "memory");
}

void time(const Workload& w, Engine* engine) {
  std::printf("%s on %s\n%10s %14s %14s %12s\n", w.name.c_str(), engine->deviceName().c_str(),
              "particles", "table+score ms", "kernel ms", "per ours CPU");
  for (const size_t n : {100, 500, 1000, 5000, 10000, 50000, 100000, 1000000}) {
    std::vector<Particle> particles;
    particles.reserve(n);
    for (size_t i = 0; i < n; ++i) particles.push_back(w.particles[i % w.particles.size()]);
    std::vector<Result> results(n);
    float kernel = 0;
    const double ms = medianMilliseconds(n > 50000 ? 10 : 50, [&] {
      engine->setImage(w.camera, w.table, w.pairs.data(), w.pairs.size());
      engine->score(w.rule, w.combination, particles.data(), n, results.data());
      kernel = engine->kernelMilliseconds();
    });
    const double cpu = w.cpu_ms * static_cast<double>(n) / static_cast<double>(w.particles.size());
    std::printf("%10zu %14.3f %14.3f %12.1f\n", n, ms, kernel, cpu / ms);
    if (n == 1000000)
      printRoofline(*engine, samplesPerParticle(w) * static_cast<double>(n), kernel);
  }
  std::printf("device memory held: %.1f MB\n", static_cast<double>(engine->deviceBytes()) / 1e6);
}

int run(const std::string& mode, const std::string& file) {
  const Workload w = readWorkload(file);
  if (mode == "emulate") {
    bool good = true;
    for (const int teams : {2, 8})
      good = report(("host emulation, " + std::to_string(teams) + " teams").c_str(), w,
                    emulate(w, teams)) &&
             good;
    return good ? kOk : kWrong;
  }
  if (const std::string why = Engine::whyUnavailable(); !why.empty()) {
    std::printf("SKIPPED: no CUDA device answers (%s)\n", why.c_str());
    return kSkipped;
  }
  Engine engine;
  load(w, &engine);
  if (mode == "time") {
    time(w, &engine);
    return kOk;
  }
  engine.setImage(w.camera, w.table, w.pairs.data(), w.pairs.size());
  std::vector<Result> results(w.particles.size()), again(w.particles.size());
  engine.score(w.rule, w.combination, w.particles.data(), w.particles.size(), results.data());
  engine.score(w.rule, w.combination, w.particles.data(), w.particles.size(), again.data());
  const bool same = std::memcmp(results.data(), again.data(), results.size() * sizeof(Result)) == 0;
  if (!same) std::printf("two calls with the same input differ: WRONG\n");
  return report(engine.deviceName().c_str(), w, results) && same ? kOk : kWrong;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc == 3 ? argv[1] : "";
  if (mode != "parity" && mode != "emulate" && mode != "time") {
    std::fprintf(stderr,
                 "usage: edge_mcl_gpu_check parity|emulate|time WORKLOAD\n"
                 "  parity   device against the CPU backend's results in the file\n"
                 "  emulate  the same kernel body on the host\n"
                 "  time     milliseconds for 100 to 1,000,000 particles\n"
                 "`edge-mcl bench SEQUENCE --dump-workload WORKLOAD` writes the file.\n");
    return kUsage;
  }
  try {
    return run(mode, argv[2]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "edge_mcl_gpu_check: %s\n", e.what());
    return kBroken;
  }
}
