#include "apps/bench/bench_table.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <string>

#include "edge_mcl/core/recordings/trajectory_evaluation.h"

namespace edge_mcl {

namespace {

/// Median time of some runs, ms. Larger numbers of particles are run less often.
double medianOfRuns(size_t particles, const std::function<void()>& work) {
  const int runs = particles <= 5000 ? 31 : particles <= 50000 ? 9 : 3;
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
                         const LikelihoodFrame& frame, const Picture& picture,
                         double plain_ms_per_particle, const std::vector<size_t>& sizes,
                         const std::function<std::vector<Pose>(size_t)>& draw, bool print) {
  if (print)
    std::printf("%9s %14s %13s %13s %16s %12s %12s %11s\n", "particles", "plain flow, ms",
                "CPU, ms", "GPU, ms", "GPU + image, ms", "plain / CPU", "plain / GPU", "CPU / GPU");
  nlohmann::json table = nlohmann::json::array();
  for (const size_t n : sizes) {
    const std::vector<Pose> poses = draw(n);
    cpu.evaluate(frame, poses);  // fills the visibility cache
    const double plain = plain_ms_per_particle * static_cast<double>(n);
    const double ours = medianOfRuns(n, [&] { cpu.evaluate(frame, poses); });
    nlohmann::json line = {{"particles", n}, {"plain_ms", plain}, {"cpu_ms", ours}};
    std::string gpu_columns = "no device";
    if (gpu) {
      const std::string device_name = gpu->name();
      gpu->evaluate(frame, poses);
      const double device = medianOfRuns(n, [&] { gpu->evaluate(frame, poses); });
      // A new picture, so that its upload, its table and the weights are timed, too.
      const auto fromImage = [&] {
        LikelihoodFrame fresh = frame;
        fresh.table = nullptr;
        fresh.picture = std::make_shared<Picture>(picture.grey(), picture.ignore(),
                                                  picture.params(), picture.levels());
        gpu->evaluate(fresh, poses);
      };
      fromImage();
      const double with_image = medianOfRuns(n, fromImage);
      if (gpu->name() == device_name) {
        line["gpu_ms"] = device;
        line["gpu_ms_with_image"] = with_image;
        char text[96];
        std::snprintf(text, sizeof text, "%.3f %16.3f %12.1f %12.1f %11.1f", device, with_image,
                      plain / ours, plain / device, ours / device);
        gpu_columns = text;
      } else {
        gpu = nullptr;  // the device has failed, and the CPU has computed the scores
        gpu_columns = "device failed";
      }
    }
    table.push_back(line);
    if (!print) continue;
    std::printf("%9zu %14.1f %13.3f %13s\n", n, plain, ours, gpu_columns.c_str());
    std::fflush(stdout);
  }
  return table;
}

}  // namespace edge_mcl
