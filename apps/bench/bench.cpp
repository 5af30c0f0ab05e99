// edge-mcl bench: the paper's flow as plainly written against our CPU path, in one run.
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/bench/bench_depth.h"
#include "apps/bench/bench_table.h"
#include "apps/bench/gather_limit.h"
#include "apps/bench/soak.h"
#include "apps/bench/stage_times.h"
#include "apps/common_options.h"
#include "apps/output_files.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/likelihood/cpu_kernel.h"
#include "edge_mcl/core/likelihood/reference_likelihood.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/gpu/backend/workload_export.h"
#include "edge_mcl/localization/backend_choice.h"

namespace edge_mcl {

namespace {

struct BenchOptions {
  std::string sequence, model, dump_workload;
  size_t image = 0, plain_particles = 100, updates = 60, samples = 0, soak = 0;
  int repeats = 15;
  std::vector<size_t> table;
  double spread_position = 0.05, spread_angle_deg = 2;
  bool depth = false, json = false;
  ParameterOptions parameters;
};

double millisecondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

double median(std::vector<double> values) { return summarize(std::move(values)).median; }

struct Timing {
  double plain = 0, one = 0, all = 0;  // ms for all particles
  double one_field = 0;                // ms for edges and table, one thread
  double gather_limit = 0;             // ns per particle-sample, look-ups alone, one thread
  uint64_t samples = 0;                // particle-samples evaluated
};

int run(const BenchOptions& o) {
  Parameters params = o.parameters.load();
  if (o.depth) params.likelihood.cues = Cues::kBoth;
  const Sequence sequence = readSequence(o.sequence);
  if (o.image >= sequence.frames.size()) throw ParameterError("--image: no such image");
  const std::string model = o.model.empty() ? sequence.model_file : o.model;
  if (model.empty()) throw InputError(o.sequence + ": no model.obj in it; use --model");
  // On the CPU until a device is asked for below.
  LocalizationMap map(model, params);
  if (o.soak > 0) {
    chooseBackend(&map);
    std::printf("%s: %.1f MB gained after the first tenth\n", map.backend().name().c_str(),
                soak(map, sequence, o.soak));
    return kExitOk;
  }
  const CpuBackend cpu(map.sharedVisibility());
  const SequenceFrame& frame = sequence.frames[o.image];
  const cv::Mat picture = readImage(frame.image_file, sequence.camera);
  const Pose centre = frame.ground_truth ? *frame.ground_truth : startOf(sequence);

  RandomSource random(params.filter.seed);
  Twist scale;
  scale.head<3>().setConstant(o.spread_position);
  scale.tail<3>().setConstant(o.spread_angle_deg * M_PI / 180);
  const auto draw = [&](size_t n) {
    std::vector<Pose> drawn;
    drawn.reserve(n);
    for (size_t i = 0; i < n; ++i)
      drawn.push_back(centre * expSe3(scale.cwiseProduct(random.normalTwist())));
    return drawn;
  };
  const std::vector<Pose> poses = draw(static_cast<size_t>(params.filter.particles));
  const size_t plain_count = std::min(poses.size(), o.plain_particles);

  if (o.depth) {
    const nlohmann::json j = timeDepth(map, sequence, frame, poses, o.repeats, !o.json);
    if (o.json) std::printf("%s\n", textOf(j).c_str());
    return kExitOk;
  }

  Timing t;
  std::vector<double> one, all, plain, field, gathers;
  std::shared_ptr<const PreparedImage> image;
  const auto withOneThread = [](const std::function<void()>& work) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    work();
  };
  image = map.prepare(sequence.camera, picture, {}, frame.image_file);
  LikelihoodFrame scored = image->frame;
  if (o.samples > 0) scored.thinning = map.thinningFor({image}, centre, o.samples);
  const std::vector<PoseScore> reference =
      cpu.evaluate(scored, poses);  // fills the visibility cache
  LikelihoodFrame paper = scored;
  paper.params.model = LikelihoodModel::kPaper;
  const auto centre_set = map.visibility().cached(map.visibility().cellOf(centre.translation()));
  // The contenders take turns, so that a drifting clock hits all of them.
  double checksum = 0;
  for (int k = 0; k < o.repeats; ++k) {
    if (k < 3)
      plain.push_back(millisecondsOf([&] {
        for (size_t i = 0; i < plain_count; ++i)
          checksum += paperFlowScore(paper, image->edges, params.image, map.visibility(), poses[i])
                          .log_likelihood;
      }));
    withOneThread([&] {
      one.push_back(millisecondsOf([&] { cpu.evaluate(scored, poses); }));
      gathers.push_back(gatherLimitNanoseconds(scored, *centre_set, poses, 1));
      field.push_back(
          millisecondsOf([&] { map.prepare(sequence.camera, picture, {}, frame.image_file); }));
    });
    all.push_back(millisecondsOf([&] { cpu.evaluate(scored, poses); }));
  }
  t.samples = cpu.lastEvaluatedSamples();
  t.gather_limit = median(gathers);
  StageTable updates_one;
  withOneThread([&] { updates_one = StageTable::measure(map, sequence, o.updates); });
  const StageTable updates_all = StageTable::measure(map, sequence, o.updates);

  const double n = static_cast<double>(poses.size());
  t.plain = median(plain) * n / static_cast<double>(plain_count);
  t.one = median(one);
  t.all = median(all);
  t.one_field = median(field);
  if (!o.dump_workload.empty()) {
    const Picture source(image->edges.grey, image->edges.ignore, params.image,
                         std::make_shared<ScoreLevels>(params.image, params.likelihood));
    gpu::Workload w =
        gpu::makeWorkload(sequence.name, map.visibility(), scored, poses, reference, &source);
    w.plain_ms = t.plain;
    w.cpu_ms = t.all;
    gpu::writeWorkload(w, o.dump_workload);
  }
  chooseBackend(&map);
  const bool has_gpu = map.backend().name().rfind("cuda", 0) == 0;
  StageTable updates_gpu;
  if (has_gpu) updates_gpu = StageTable::measure(map, sequence, o.updates);
  const double per_sample_one = 1e6 * t.one / static_cast<double>(t.samples);
  const int threads = tbb::info::default_concurrency();
  nlohmann::json j = {{"sequence", sequence.name},
                      {"likelihood", params.get("likelihood.model")},
                      {"particles", poses.size()},
                      {"thinning", scored.thinning},
                      {"particle_samples", t.samples},
                      {"instruction_set", kernelTargetName()},
                      {"threads", threads},
                      {"plain_flow_ms", t.plain},
                      {"plain_flow_particles_timed", plain_count},
                      {"cpu_one_thread_ms", t.one},
                      {"cpu_all_threads_ms", t.all},
                      {"image_one_thread_ms", t.one_field},
                      {"ns_per_particle_sample_one_thread", per_sample_one},
                      {"ns_per_particle_sample_gathers_alone", t.gather_limit},
                      {"ratio_one_thread_to_gathers_alone", per_sample_one / t.gather_limit},
                      {"ratio_plain_to_one_thread", t.plain / t.one},
                      {"ratio_plain_to_one_thread_with_image", t.plain / (t.one + t.one_field)},
                      {"ratio_one_to_all_threads", t.one / t.all},
                      {"update_ms_one_thread", updates_one.toJson()},
                      {"update_ms_all_threads", updates_all.toJson()},
                      {"backend", map.backend().name()},
                      {"update_ms_gpu", updates_gpu.toJson()},
                      {"peak_resident_mb", peakResidentMegabytes()},
                      {"checksum", checksum}};
  const auto timeSizes = [&] {
    return timeTable(cpu, has_gpu ? &map.backend() : nullptr, scored,
                     Picture(image->edges.grey, image->edges.ignore, params.image,
                             std::make_shared<ScoreLevels>(params.image, params.likelihood)),
                     t.plain / static_cast<double>(poses.size()), o.table, draw, !o.json);
  };
  if (o.json) {
    if (!o.table.empty()) j["table"] = timeSizes();
    std::printf("%s\n", textOf(j).c_str());
    return kExitOk;
  }
  std::printf("%s, image %zu: %zu particles, %.0f samples each (after culling), %s\n",
              sequence.name.c_str(), o.image, poses.size(), static_cast<double>(t.samples) / n,
              kernelTargetName());
  std::printf("  %-42s %10s %16s %8s\n", "", "ms", "ns/part.-sample", "ratio");
  const auto row = [&](const char* name, double ms, double ratio) {
    std::printf("  %-42s %10.2f %16.2f %8.1f\n", name, ms,
                1e6 * ms / static_cast<double>(t.samples), ratio);
  };
  row("paper's flow, plainly written, 1 thread", t.plain, 1);
  row("ours, 1 thread", t.one, t.plain / t.one);
  row(("ours, " + std::to_string(threads) + " threads").c_str(), t.all, t.plain / t.all);
  std::printf("  %-42s %10s %16.2f   ours is %.2f times that\n", "look-ups alone, 1 thread", "",
              t.gather_limit, per_sample_one / t.gather_limit);
  std::printf("  edges and table of the image, 1 thread     %10.2f ms (once per image)\n",
              t.one_field);
  updates_one.print("whole update, image in, pose out, 1 thread");
  updates_all.print("the same, " + std::to_string(threads) + " threads");
  updates_gpu.print("the same, " + map.backend().name());
  std::printf("  peak resident size %.0f MB\n", peakResidentMegabytes());
  if (!o.table.empty()) timeSizes();
  return kExitOk;
}

}  // namespace

void addBench(CLI::App* app, Action* action) {
  auto o = std::make_shared<BenchOptions>();
  CLI::App* c = app->add_subcommand(
      "bench", "time the likelihood: the paper's flow plainly written against ours, in one run");
  c->add_option("sequence", o->sequence, "sequence directory: its model, one image, its camera")
      ->required();
  c->add_option("--model", o->model, "model file, if not SEQUENCE/model.obj");
  c->add_option("--image", o->image, "number of the image");
  c->add_option("--repeats", o->repeats, "measurements; the median is reported")
      ->check(CLI::Range(1, 10000));
  c->add_option("--plain-particles", o->plain_particles,
                "particles timed with the plain flow (scaled up)");
  c->add_option("--updates", o->updates, "images of which the whole update is timed");
  c->add_option("--samples", o->samples,
                "thin the model's samples out to about so many per particle, for all contenders");
  c->add_option("--spread-position", o->spread_position, "spread of the particles, m");
  c->add_option("--spread-angle", o->spread_angle_deg, "spread of the particles, deg");
  CLI::Option* soaking = c->add_option(
      "--soak", o->soak,
      "instead of timing: so many updates in a row, with the resident size along the way");
  CLI::Option* depth =
      c->add_flag("--depth", o->depth, "time the depth likelihood instead")->excludes(soaking);
  c->add_option("--table", o->table,
                "numbers of particles for a table like the paper's Table 1, e.g. "
                "100,500,1000,5000,50000,1000000")
      ->delimiter(',')
      ->check(CLI::Range(1, 10000000))
      ->excludes(soaking)
      ->excludes(depth);
  c->add_option("--dump-workload", o->dump_workload,
                "file for `edge_mcl_gpu_check`: this image and these particles, for a machine with "
                "a GPU and nothing else")
      ->excludes(soaking)
      ->excludes(depth);
  c->add_flag("--json", o->json, "print the result as JSON")->excludes(soaking);
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
