#include "bench_table.h"

#include <chrono>
#include <cstdio>

#include "edge_mcl/core/trajectory_evaluation.h"

namespace edge_mcl {

namespace {

double medianOfRuns(size_t particles, const std::function<void()>& work) {
  // A second at most for the small ones, one run for the large ones.
  const int runs = particles <= 5000 ? 9 : particles <= 50000 ? 3 : 1;
  std::vector<double> ms;
  ms.reserve(runs);
  for (int i = 0; i < runs; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                     .count());
  }
  return summarize(std::move(ms)).median;
}

}  // namespace

nlohmann::json timeTable(const LikelihoodBackend& cpu, const LikelihoodBackend* gpu,
                         const LikelihoodFrame& frame, double plain_ms_per_particle,
                         const std::vector<size_t>& sizes,
                         const std::function<std::vector<Pose>(size_t)>& draw, bool print) {
  if (print)
    std::printf("%10s %16s %14s %14s %14s %14s\n", "N", "t_CPU plain, ms", "t_CPU ours, ms",
                "t_GPU, ms", "plain / ours", "plain / GPU");
  nlohmann::json table = nlohmann::json::array();
  for (const size_t n : sizes) {
    const std::vector<Pose> poses = draw(n);
    cpu.evaluate(frame, poses);  // fills the visibility cache
    const double plain = plain_ms_per_particle * static_cast<double>(n);
    const double ours = medianOfRuns(n, [&] { cpu.evaluate(frame, poses); });
    nlohmann::json line = {{"particles", n}, {"plain_ms", plain}, {"cpu_ms", ours}};
    char gpu_ms[32] = "no device", gpu_ratio[32] = "";
    if (gpu) {
      gpu->evaluate(frame, poses);
      const double device = medianOfRuns(n, [&] { gpu->evaluate(frame, poses); });
      line["gpu_ms"] = device;
      std::snprintf(gpu_ms, sizeof gpu_ms, "%.2f", device);
      std::snprintf(gpu_ratio, sizeof gpu_ratio, "%.1f", plain / device);
    }
    table.push_back(line);
    if (!print) continue;
    std::printf("%10zu %16.1f %14.2f %14s %14.1f %14s\n", n, plain, ours, gpu_ms, plain / ours,
                gpu_ratio);
    std::fflush(stdout);
  }
  return table;
}

}  // namespace edge_mcl
