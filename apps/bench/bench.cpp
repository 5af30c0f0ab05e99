// edge-mcl bench: times the paper's algorithm, plainly written, and this program in one run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/bench/bench_depth.h"
#include "apps/bench/bench_likelihood.h"
#include "apps/bench/soak.h"
#include "apps/common_options.h"
#include "apps/output_files.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/map_factory.h"

namespace edge_mcl {

namespace {

struct BenchOptions : BenchSettings {
  std::string sequence, model, dump_workload;
  size_t soak = 0;
  std::vector<size_t> table;
  bool depth = false, json = false;
  ParameterOptions parameters;
};

int run(const BenchOptions& o) {
  Parameters params = o.parameters.load();
  if (o.depth) params.likelihood.cues = Cues::kBoth;
  const Sequence sequence = readSequence(o.sequence);
  const std::string model = o.model.empty() ? sequence.model_file : o.model;
  if (model.empty())
    throw InputError(o.sequence + ": the directory has no model.obj; name the model with --model");
  const auto map = std::make_shared<LocalizationMap>(model, params);
  if (o.soak > 0) {
    chooseBackend(map.get());
    std::printf("%s: memory grew by %.1f MB after the first tenth of the updates\n",
                map->backend().name().c_str(), soak(*map, sequence, o.soak));
    return kExitOk;
  }
  LikelihoodBench bench(map, sequence, o);
  if (o.depth) {
    const nlohmann::json j =
        timeDepth(*map, sequence, sequence.frames[o.image], bench.poses(), o.repeats, !o.json);
    if (o.json) std::printf("%s\n", textOf(j).c_str());
    return kExitOk;
  }
  bench.timeCpu();
  if (!o.dump_workload.empty()) bench.dumpWorkload(o.dump_workload);
  bench.timeBackend();
  if (!o.json) bench.print();
  nlohmann::json j = bench.toJson();
  if (!o.table.empty()) j["table"] = bench.timeSizes(o.table, !o.json);
  if (o.json) std::printf("%s\n", textOf(j).c_str());
  return kExitOk;
}

}  // namespace

void addBench(CLI::App* app, Action* action) {
  auto o = std::make_shared<BenchOptions>();
  CLI::App* c = app->add_subcommand(
      "bench",
      "time the likelihood: the paper's algorithm, plainly written (the plain flow), and this "
      "program in one run");
  c->add_option("sequence", o->sequence,
                "sequence directory, whose model, camera and one image are used")
      ->required();
  c->add_option("--model", o->model, "model file; default: SEQUENCE/model.obj");
  c->add_option("--image", o->image, "number of the image, from 0; default 0");
  c->add_option("--repeats", o->repeats,
                "number of measurements, whose median is reported; default 15")
      ->check(CLI::Range(1, 10000));
  c->add_option(
      "--plain-particles", o->plain_particles,
      "number of particles timed with the plain flow; the time is scaled up to all particles; "
      "default 100");
  c->add_option("--updates", o->updates,
                "number of images whose whole update is timed; default 60");
  c->add_option(
      "--samples", o->samples,
      "approximate number of samples per particle after the model is thinned out, for all "
      "measured programs; 0 (default): all samples");
  c->add_option("--spread-position", o->spread_position,
                "standard deviation of the particles' positions per axis, m; default 0.05");
  c->add_option("--spread-angle", o->spread_angle_deg,
                "standard deviation of the particles' rotations per axis, degrees; default 2");
  CLI::Option* soaking = c->add_option(
      "--soak", o->soak,
      "number of updates in a row, on the way of which the resident memory is printed; nothing is "
      "timed; 0 (default): the likelihood is timed");
  CLI::Option* depth =
      c->add_flag("--depth", o->depth, "time the depth likelihood in place of the edge likelihood")
          ->excludes(soaking);
  c->add_option("--table", o->table,
                "numbers of particles for a table like the paper's Table 1, e.g. "
                "100,500,1000,5000,50000,1000000; default: no table")
      ->delimiter(',')
      ->check(CLI::Range(1, 10000000))
      ->excludes(soaking)
      ->excludes(depth);
  c->add_option(
       "--dump-workload", o->dump_workload,
       "file to write for `edge_mcl_gpu_check`, with this image and these particles, for a "
       "machine that has only a GPU and not this program; default: none")
      ->excludes(soaking)
      ->excludes(depth);
  c->add_flag("--json", o->json, "print the result as JSON; default: as text")->excludes(soaking);
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
