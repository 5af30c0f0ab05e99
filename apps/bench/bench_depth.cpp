#include "apps/bench/bench_depth.h"

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <chrono>
#include <cstdio>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"

namespace edge_mcl {

nlohmann::json timeDepth(const LocalizationMap& map, const Sequence& sequence,
                         const SequenceFrame& frame, const std::vector<Pose>& poses, int repeats,
                         bool print) {
  if (frame.depth_file.empty())
    throw InputError(frame.image_file + ": this image has no depth image");
  DepthImage image;
  image.camera = sequence.camera;
  image.depth = readDepth(frame.depth_file, sequence.camera);
  image.units_per_metre = sequence.depth_scale;
  image.origin = frame.depth_file;
  const DepthLikelihood& likelihood = *map.depth();
  std::shared_ptr<const DepthPoints> points;
  const auto millisecondsOf = [](const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
  };
  double checksum = 0;
  const auto evaluate = [&] { checksum += likelihood.evaluate(*points, poses)[0].log_likelihood; };
  std::vector<double> preparing, plain, one, all;
  for (int k = 0; k < repeats; ++k) {
    preparing.push_back(millisecondsOf([&] { points = map.prepareDepth(image); }));
    if (k < 3)
      plain.push_back(millisecondsOf([&] {
        for (const Pose& pose : poses)
          checksum += likelihood.evaluateSlowly(*points, pose).log_likelihood;
      }));
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
      one.push_back(millisecondsOf(evaluate));
    }
    all.push_back(millisecondsOf(evaluate));
  }
  const auto summary = [](std::vector<double> v) { return summarize(std::move(v)); };
  nlohmann::json j = {{"points", points->count},
                      {"particles", poses.size()},
                      {"threads", tbb::info::default_concurrency()},
                      {"prepare_ms", summary(preparing).median},
                      {"plain_ms", summary(plain).median},
                      {"one_thread_ms", summary(one).median},
                      {"all_threads_ms", summary(all).median},
                      {"all_threads_ms_p90", summary(all).p90},
                      {"field_mb", static_cast<double>(likelihood.field().size()) / 1e6},
                      {"voxel_size_m", likelihood.field().voxelSize()},
                      {"checksum", checksum}};
  if (print) {
    std::printf("depth: %zu points, %zu particles, distance field of %.1f MB\n", points->count,
                poses.size(), j["field_mb"].get<double>());
    std::printf(
        "  making the points %.2f ms; point by point in double precision, 1 thread %.2f ms\n",
        j["prepare_ms"].get<double>(), j["plain_ms"].get<double>());
    std::printf("  ours, 1 thread %.2f ms (%.1f times as fast), all threads %.2f ms (p90 %.2f)\n",
                j["one_thread_ms"].get<double>(),
                j["plain_ms"].get<double>() / j["one_thread_ms"].get<double>(),
                j["all_threads_ms"].get<double>(), j["all_threads_ms_p90"].get<double>());
  }
  return j;
}

}  // namespace edge_mcl
