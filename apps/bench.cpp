// edge-mcl bench: the paper's flow as plainly written against our CPU path, in one run.
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench_table.h"
#include "common_options.h"
#include "edge_mcl/core/cpu_kernel.h"
#include "edge_mcl/core/error.h"
#include "edge_mcl/core/reference_likelihood.h"
#include "edge_mcl/core/sequence.h"
#include "edge_mcl/core/trajectory_evaluation.h"
#include "edge_mcl/gpu/workload_export.h"
#include "edge_mcl/mrpt_plugins/backend_choice.h"
#include "edge_mcl/mrpt_plugins/sequence_localizer.h"

namespace edge_mcl {

namespace {

struct BenchOptions {
  std::string sequence, model, dump_workload;
  size_t image = 0, plain_particles = 100, updates = 60;
  int repeats = 15;
  std::vector<size_t> table;
  double spread_position = 0.05, spread_angle_deg = 2;
  bool json = false;
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
  double plain = 0, one = 0, all = 0;   // ms for all particles
  double one_field = 0;                 // ms for edges and table, one thread
  uint64_t samples = 0;                 // particle-samples evaluated
  ErrorSummary update_one, update_all;  // ms of whole updates
};

std::vector<double> wholeUpdates(const LocalizationMap& map, const Sequence& sequence,
                                 size_t most) {
  SequenceLocalizer localizer(map, sequence, true);
  std::vector<double> ms;
  ms.reserve(most);
  for (size_t i = 0; i < std::min(most, sequence.frames.size()); ++i) {
    const FrameResult r = localizer.step();
    if (r.updated)
      ms.push_back(r.image_times.edges + r.image_times.field + r.image_times.table +
                   r.report.total_ms);
  }
  return ms;
}

double percentile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  return v[static_cast<size_t>(q * static_cast<double>(v.size() - 1))];
}

int run(const BenchOptions& o) {
  const Parameters params = o.parameters.load();
  const Sequence sequence = readSequence(o.sequence);
  if (o.image >= sequence.frames.size()) throw ParameterError("--image: no such image");
  const std::string model = o.model.empty() ? sequence.model_file : o.model;
  if (model.empty()) throw InputError(o.sequence + ": no model.obj in it; use --model");
  LocalizationMap map(model, params);
  chooseBackend(&map);
  const CpuBackend cpu(map.sharedVisibility());
  const SequenceFrame& frame = sequence.frames[o.image];
  const cv::Mat picture = readImage(frame.image_file, sequence.camera);
  const Pose centre = frame.ground_truth.value_or(sequence.initial_pose);

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

  Timing t;
  std::vector<double> one, all, plain, field;
  std::vector<double> updates_one, updates_all;
  std::shared_ptr<const PreparedImage> image;
  const auto withOneThread = [](const std::function<void()>& work) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    work();
  };
  image = map.prepare(sequence.camera, picture, {}, frame.image_file);
  const std::vector<PoseScore> reference =
      cpu.evaluate(image->frame, poses);  // fills the visibility cache
  LikelihoodFrame paper = image->frame;
  paper.params.model = LikelihoodModel::kPaper;
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
      one.push_back(millisecondsOf([&] { cpu.evaluate(image->frame, poses); }));
      field.push_back(
          millisecondsOf([&] { map.prepare(sequence.camera, picture, {}, frame.image_file); }));
    });
    all.push_back(millisecondsOf([&] { cpu.evaluate(image->frame, poses); }));
  }
  t.samples = cpu.lastEvaluatedSamples();
  withOneThread([&] { updates_one = wholeUpdates(map, sequence, o.updates); });
  updates_all = wholeUpdates(map, sequence, o.updates);

  const double n = static_cast<double>(poses.size());
  t.plain = median(plain) * n / static_cast<double>(plain_count);
  t.one = median(one);
  t.all = median(all);
  t.one_field = median(field);
  if (!o.dump_workload.empty()) {
    gpu::Workload w =
        gpu::makeWorkload(sequence.name, map.visibility(), image->frame, poses, reference);
    w.plain_ms = t.plain;
    w.cpu_ms = t.all;
    gpu::writeWorkload(w, o.dump_workload);
  }
  const double per_sample_one = 1e6 * t.one / static_cast<double>(t.samples);
  const int threads = tbb::info::default_concurrency();
  nlohmann::json j = {
      {"sequence", sequence.name},
      {"likelihood", params.get("likelihood.model")},
      {"particles", poses.size()},
      {"particle_samples", t.samples},
      {"instruction_set", kernelTargetName()},
      {"threads", threads},
      {"plain_flow_ms", t.plain},
      {"plain_flow_particles_timed", plain_count},
      {"cpu_one_thread_ms", t.one},
      {"cpu_all_threads_ms", t.all},
      {"image_one_thread_ms", t.one_field},
      {"ns_per_particle_sample_one_thread", per_sample_one},
      {"ratio_plain_to_one_thread", t.plain / t.one},
      {"ratio_plain_to_one_thread_with_image", t.plain / (t.one + t.one_field)},
      {"ratio_one_to_all_threads", t.one / t.all},
      {"update_ms_one_thread",
       {{"p50", percentile(updates_one, 0.5)}, {"p95", percentile(updates_one, 0.95)}}},
      {"update_ms_all_threads",
       {{"p50", percentile(updates_all, 0.5)}, {"p95", percentile(updates_all, 0.95)}}},
      {"checksum", checksum}};
  const bool has_gpu = map.backend().name().rfind("cuda", 0) == 0;
  const auto timeSizes = [&] {
    return timeTable(cpu, has_gpu ? &map.backend() : nullptr, image->frame,
                     t.plain / static_cast<double>(poses.size()), o.table, draw, !o.json);
  };
  if (o.json) {
    if (!o.table.empty()) j["table"] = timeSizes();
    std::printf("%s\n", j.dump(1).c_str());
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
  std::printf("  edges and table of the image, 1 thread     %10.2f ms (once per image)\n",
              t.one_field);
  if (!updates_all.empty())
    std::printf(
        "  whole update, image in, pose out: 1 thread p50 %.1f p95 %.1f ms; %d threads p50 "
        "%.1f p95 %.1f ms\n",
        percentile(updates_one, 0.5), percentile(updates_one, 0.95), threads,
        percentile(updates_all, 0.5), percentile(updates_all, 0.95));
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
  c->add_option("--spread-position", o->spread_position, "spread of the particles, m");
  c->add_option("--spread-angle", o->spread_angle_deg, "spread of the particles, deg");
  c->add_option("--table", o->table,
                "numbers of particles for a table like the paper's Table 1, e.g. "
                "100,500,1000,5000,50000,1000000")
      ->delimiter(',')
      ->check(CLI::Range(1, 10000000));
  c->add_option("--dump-workload", o->dump_workload,
                "file for `edge_mcl_gpu_check`: this image and these particles, for a machine with "
                "a GPU and nothing else");
  c->add_flag("--json", o->json, "print the result as JSON");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
