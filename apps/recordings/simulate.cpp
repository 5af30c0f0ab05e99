// edge-mcl simulate: flies a scenario and writes a sequence directory, a bag or a rawlog.
#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <future>
#include <memory>
#include <optional>

#include "apps/common_options.h"
#include "apps/number_range.h"
#include "apps/progress_bar.h"
#include "apps/recordings/recorder_choice.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/sim/sequence_writer.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {

namespace {

volatile std::sig_atomic_t interrupted = 0;

struct SimulateOptions {
  std::string scenario, out;
  std::optional<uint64_t> seed;
  std::optional<double> rate;
  size_t images = 0;
  bool no_objects = false;
};

std::unique_ptr<Recorder> recorderFor(const std::string& out, const Simulator& simulator) {
  const RecordingSetup setup = simulator.setup();
  if (auto recorder = recorderForFile(out, setup, {})) return recorder;
  return std::make_unique<SequenceWriter>(out, setup, simulator.scenario().model_file,
                                          simulator.notes());
}

int run(const SimulateOptions& o) {
  Scenario scenario = Scenario::fromYamlFile(o.scenario);
  if (o.seed) scenario.seed = *o.seed;
  if (o.rate) scenario.rate = *o.rate;
  if (o.no_objects) scenario.objects.clear();
  Simulator simulator(std::move(scenario));
  const Scenario& s = simulator.scenario();
  const std::unique_ptr<Recorder> recorder = recorderFor(o.out, simulator);
  if (!s.path_is_of_camera) recorder->writeImu(simulateImu(s.path, s.imu, s.seed * 3));
  const size_t total =
      o.images > 0 ? std::min(o.images, simulator.imageCount()) : simulator.imageCount();
  const auto previous = std::signal(SIGINT, [](int) { interrupted = 1; });
  ProgressBar bar("simulate", total);
  const auto start = std::chrono::steady_clock::now();
  size_t dropped = 0;
  std::future<void> writing;  // writes one image while the next one is rendered
  size_t flown = 0;
  for (; flown < total && !interrupted; ++flown) {
    auto frame = std::make_shared<RecordedFrame>();
    const bool arrived = simulator.next(frame.get());
    if (writing.valid()) writing.get();
    if (arrived)
      writing = std::async(std::launch::async, [&recorder, frame] { recorder->write(*frame); });
    else
      ++dropped;
    bar.advance();
  }
  if (writing.valid()) writing.get();
  std::signal(SIGINT, previous);
  recorder->close();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const bool complete = flown == total;
  std::printf("%s: %zu images%s, %zu dropped by the faults of the scenario, %.1f images/s\n",
              o.out.c_str(), recorder->count(), complete ? "" : " (interrupted)", dropped,
              static_cast<double>(recorder->count()) / seconds);
  return complete ? kExitOk : kExitIncomplete;
}

}  // namespace

void addSimulate(CLI::App* app, Action* action) {
  auto o = std::make_shared<SimulateOptions>();
  CLI::App* c = app->add_subcommand(
      "simulate",
      "fly a camera through a model and write colour, depth, masks, odometry, IMU, ground truth");
  c->add_option("scenario", o->scenario,
                "YAML file with model, camera, path, objects and faults (see docs/simulator.md)")
      ->required();
  c->add_option("out", o->out,
                "recording to write: a sequence directory, a ROS bag *.bag or an MRPT rawlog "
                "*.rawlog; nothing is overwritten")
      ->required();
  c->add_option("--seed", o->seed,
                "seed of all noise and of a random path; default: the seed of the scenario");
  c->add_option("--rate", o->rate, "images per second; default: the rate of the scenario")
      ->check(numberFrom(0.1, 1000));
  c->add_option("--images", o->images,
                "number of images after which the flight stops; 0 (default): the whole path");
  c->add_flag("--no-objects", o->no_objects,
              "fly without the movable objects; default: with the objects of the scenario");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
