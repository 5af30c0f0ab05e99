// edge_mcl_gpu_check: runs a workload file on the device (parity, time, soak) or in the host
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

#include "edge_mcl/gpu/emulation/host_emulation.h"
#include "edge_mcl/gpu/emulation/table_emulation.h"
#include "edge_mcl/gpu/engine/engine.h"
#include "edge_mcl/gpu/workload/workload.h"

namespace {

using namespace edge_mcl::gpu;

constexpr int kOk = 0, kWrong = 1, kUsage = 2, kBroken = 3, kSkipped = 77;
/// Allowed difference of log-likelihoods. Single precision places a sample with an error of about
/// 3e-5 pixels, and a score changes by up to 5 per pixel. The discounts of the likelihood bring the
/// error of the sum below this value.
constexpr double kTolerance = 1e-3;

struct Agreement {
  double largest = 0;  ///< difference of log-likelihoods
  /// Number of ranks among the best 100 at which reference and result have different particles.
  /// Only pairs whose reference values differ by more than the tolerance count.
  size_t swapped = 0;
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
  for (const Cell& c : w.cells)
    engine->addCell(c, w.chunks.data() + c.first_chunk,
                    w.samples.data() + static_cast<size_t>(c.first_chunk) * kLanes);
}

bool hasPicture(const Workload& w) { return w.recipe.work.bins > 0; }

void setImage(const Workload& w, Engine* engine) {
  if (!hasPicture(w)) return engine->setTable(0, w.camera, w.table, w.pairs.data(), w.pairs.size());
  const auto width = static_cast<size_t>(w.recipe.work.width);
  engine->setPicture(0, w.camera, w.table, w.recipe,
                     {w.grey.data(), width, w.ignore.empty() ? nullptr : w.ignore.data(), width});
}

/// Scores the particles. They are copied in batches, while the device works on the batch before.
const Result* score(const Workload& w, const std::vector<Particle>& particles, Engine* engine) {
  constexpr size_t kBatch = 131072;
  Particle* to = engine->particles(particles.size());
  for (size_t first = 0; first < particles.size(); first += kBatch) {
    const size_t count = std::min(kBatch, particles.size() - first);
    std::memcpy(to + first, particles.data() + first, count * sizeof *to);
    engine->submit(0, w.rule, w.combination, first, count);
  }
  return engine->wait();
}

std::vector<Result> scoreAll(const Workload& w, Engine* engine) {
  const Result* results = score(w, w.particles, engine);
  return {results, results + w.particles.size()};
}

/// Compares a table with the table of the workload. They must be equal to the last bit.
bool reportTable(const char* what, const Workload& w, const std::vector<Quad>& made) {
  const std::vector<Quad> expected = emulateTable(w.table, w.pairs.data());
  size_t differ = made.size() == expected.size() ? 0 : expected.size();
  for (size_t i = 0; i < std::min(made.size(), expected.size()); ++i)
    differ += made[i].top != expected[i].top || made[i].bottom != expected[i].bottom;
  std::printf("%s: table of %zu elements, %zu of them differ: %s\n", what, expected.size(), differ,
              differ == 0 ? "ok" : "WRONG");
  return differ == 0;
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

/// Mean amount of work of the kernel per particle.
struct Work {
  double chunks = 0, samples = 0;  ///< numbers in the particle's cell
  double samples_seen = 0;         ///< number of samples in chunks that may be in view
};

Work workPerParticle(const Workload& w) {
  Work sum;
  for (const Particle& p : w.particles) {
    const Cell& cell = w.cells[p.cell];
    Pose pose{};
    for (int i = 0; i < 12; ++i) fillPose(p, cell, i, &pose);
    for (uint32_t c = 0; c < cell.chunk_count; ++c) {
      const Chunk& chunk = w.chunks[cell.first_chunk + c];
      sum.chunks += 1;
      sum.samples += chunk.count;
      if (mayBeInView(w.camera, pose, chunk)) sum.samples_seen += chunk.count;
    }
  }
  const auto n = static_cast<double>(w.particles.size());
  return {sum.chunks / n, sum.samples / n, sum.samples_seen / n};
}

/// Prints how near the largest run came to the limits of the device.
void printRoofline(const Engine& engine, double samples, double kernel_ms) {
  // Operations: single-precision operations for a sample without distortion, counted in scoreSample
  // and transformPoint. Bytes: every look-up counts as if it read a sector of 32 bytes of memory.
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
  const Work work = workPerParticle(w);
  std::printf(
      "%s on %s\n%.0f samples per particle visible from its cell, %.0f of them in chunks "
      "in view\n",
      w.name.c_str(), engine->deviceName().c_str(), work.samples, work.samples_seen);
  std::printf("%10s %18s %14s %14s\n", "particles", "image to weights", "weights", "kernel, ms");
  for (const size_t n : {100, 500, 1000, 5000, 10000, 50000, 100000, 1000000}) {
    std::vector<Particle> particles;
    particles.reserve(n);
    for (size_t i = 0; i < n; ++i) particles.push_back(w.particles[i % w.particles.size()]);
    const int repeats = n > 50000 ? 10 : 200;
    const auto fromImage = [&] {
      setImage(w, engine);
      score(w, particles, engine);
    };
    fromImage();  // the first run allocates memory
    const double image = medianMilliseconds(repeats, fromImage);
    const double weights = medianMilliseconds(repeats, [&] { score(w, particles, engine); });
    const float last = engine->kernelMilliseconds();  // of the last batch
    if (n <= 100000) {
      std::printf("%10zu %18.3f %14.3f %14.3f\n", n, image, weights, last);
      continue;
    }
    // All particles are in one batch to measure the kernel alone.
    std::memcpy(engine->particles(n), particles.data(), n * sizeof(Particle));
    engine->submit(0, w.rule, w.combination, 0, n);
    engine->wait();
    engine->submit(0, w.rule, w.combination, 0, n);
    engine->wait();
    const float kernel = engine->kernelMilliseconds();
    std::printf("%10zu %18.3f %14.3f %14.3f\n", n, image, weights, kernel);
    printRoofline(*engine, work.samples_seen * static_cast<double>(n), kernel);
  }
  if (hasPicture(w)) {
    std::vector<double> ms;
    const double host = medianMilliseconds(200, [&] {
      setImage(w, engine);
      ms.push_back(engine->pictureMilliseconds());
    });
    std::nth_element(ms.begin(), ms.begin() + 100, ms.end());
    std::printf("picture to table: %.3f ms, on the device %.3f ms\n", host, ms[100]);
  }
  std::printf("device memory held: %.1f MB\n", static_cast<double>(engine->deviceBytes()) / 1e6);
}

double residentMegabytes() {
  long pages = 0, resident = 0;
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (!file) return 0;
  if (std::fscanf(file, "%ld %ld", &pages, &resident) != 2) resident = 0;
  std::fclose(file);
  return static_cast<double>(resident) * 4096 / 1e6;
}

/// Processes many images. The memory of neither the host nor the device may grow.
int soak(const Workload& w, Engine* engine) {
  constexpr int kUpdates = 100000;
  double host = 0, device = 0;
  for (int i = 1; i <= kUpdates; ++i) {
    setImage(w, engine);
    score(w, w.particles, engine);
    if (i % (kUpdates / 10) != 0) continue;
    const double resident = residentMegabytes(),
                 free = 1e-6 * static_cast<double>(Engine::freeBytes());
    if (i == kUpdates / 10) {
      host = resident;
      device = free;
    }
    std::printf("%6d updates: resident %.1f MB, free on the device %.1f MB\n", i, resident, free);
    if (i == kUpdates) {
      const bool good = resident - host < 1 && device - free < 1;
      std::printf("gained since the first tenth: %.1f MB, on the device %.1f MB: %s\n",
                  resident - host, device - free, good ? "ok" : "WRONG");
      return good ? kOk : kWrong;
    }
  }
  return kOk;
}

int run(const std::string& mode, const std::string& file) {
  const Workload w = readWorkload(file);
  if (w.particles.empty()) throw std::runtime_error(file + ": no particles in it");
  if (mode == "emulate") {
    bool good = true;
    if (hasPicture(w)) {
      const auto width = static_cast<size_t>(w.recipe.work.width);
      good = reportTable(
          "host emulation", w,
          emulateTable(w.recipe, {w.grey.data(), width,
                                  w.ignore.empty() ? nullptr : w.ignore.data(), width}));
    }
    const std::vector<Quad> quads = emulateTable(w.table, w.pairs.data());
    for (const int warps : {1, kParts})
      good = report(("host emulation, " + std::to_string(warps) + " warps").c_str(), w,
                    emulate(w, quads, warps)) &&
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
  if (mode == "soak") return soak(w, &engine);
  bool good = true;
  setImage(w, &engine);
  good = reportTable(engine.deviceName().c_str(), w, engine.table(0));
  const std::vector<Result> results = scoreAll(w, &engine);
  good = report(engine.deviceName().c_str(), w, results) && good;
  setImage(w, &engine);
  const std::vector<Result> again = scoreAll(w, &engine);
  if (std::memcmp(results.data(), again.data(), results.size() * sizeof(Result)) != 0) {
    std::printf("two calls with the same input differ: WRONG\n");
    good = false;
  }
  return good ? kOk : kWrong;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc == 3 ? argv[1] : "";
  if (mode != "parity" && mode != "emulate" && mode != "time" && mode != "soak") {
    std::fprintf(stderr,
                 "usage: edge_mcl_gpu_check parity|emulate|time|soak WORKLOAD\n"
                 "  parity   compares the device with the CPU backend's results in the file\n"
                 "  emulate  runs the kernel body on the host and compares it\n"
                 "  time     measures milliseconds for 100 to 1,000,000 particles\n"
                 "  soak     checks the memory during 100,000 images\n"
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
