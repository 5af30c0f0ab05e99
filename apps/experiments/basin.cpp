// edge-mcl basin: starts the filter with an error and counts how often one image leads it to the
// right pose.
#include <tbb/parallel_for.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/localization/filter/pose_filter.h"
#include "edge_mcl/localization/map_factory.h"

namespace edge_mcl {

namespace {

struct BasinOptions {
  std::string sequence, model;
  double offset = 0.2, angle = 3;
  int trials = 10, repeats = 5;
  bool json = false, no_mask = false;
  ParameterOptions parameters;
};

constexpr double kGoodPosition = 0.10, kGoodAngle = 3 * kDegree;

/// The true pose, displaced by `offset` (m) in a random direction and turned by `angle` (rad) about
/// a random axis. The amounts are exact.
Pose displaced(const Pose& truth, double offset, double angle, RandomSource* random) {
  Pose start = truth;
  start.translation() += offset * random->direction();
  start.linear() = start.linear() * expSo3(angle * random->direction());
  return start;
}

/// Errors of the filter's pose at the end of a trial, m and rad.
struct Trial {
  double position = 0, angle = 0;
};

Trial runTrial(const LocalizationMap& map, const std::shared_ptr<const PreparedImage>& image,
               const Pose& truth, const BasinOptions& o, uint64_t seed) {
  RandomSource random(seed);
  FilterParameters filter_params = map.params().filter;
  filter_params.seed = seed;
  PoseFilter filter(filter_params, map.params().refinement);
  // Standard deviations per axis. Over the three axes they add up to the real displacement.
  filter.initialize(displaced(truth, o.offset, o.angle * kDegree, &random),
                    o.offset / std::sqrt(3.0), o.angle * kDegree / std::sqrt(3.0));
  for (int k = 0; k < o.repeats; ++k) {
    if (k > 0) filter.predictWithOdometry(Pose::Identity(), 0.1);
    filter.update(map, {{image, Pose::Identity()}});
  }
  return {(filter.estimate().mean.translation() - truth.translation()).norm(),
          rotationAngle(filter.estimate().mean, truth)};
}

int run(const BasinOptions& o) {
  const Parameters params = o.parameters.load();
  if (!(o.offset >= 0) || !(o.angle >= 0) || o.trials < 1 || o.repeats < 1)
    throw ParameterError(
        "basin: --offset and --angle must be at least 0, and --trials and --repeats "
        "at least 1");
  const Sequence sequence = readSequence(o.sequence);
  const std::string model = o.model.empty() ? sequence.model_file : o.model;
  if (model.empty())
    throw InputError(o.sequence + ": the directory has no model.obj; name the model with --model");
  const std::shared_ptr<const LocalizationMap> shared_map = makeMap(model, params);
  const LocalizationMap& map = *shared_map;
  std::vector<double> position, angle;
  size_t good = 0, total = 0, unusable = 0;
  nlohmann::json images = nlohmann::json::array();
  ProgressBar bar("basin", sequence.frames.size());
  for (size_t f = 0; f < sequence.frames.size(); ++f) {
    const SequenceFrame& frame = sequence.frames[f];
    bar.advance();
    if (!frame.ground_truth) continue;
    std::shared_ptr<const PreparedImage> image;
    try {
      cv::Mat mask;
      if (!o.no_mask && !frame.mask_file.empty()) mask = readMask(frame.mask_file, sequence.camera);
      image = map.prepare(sequence.camera, readImage(frame.image_file, sequence.camera), mask,
                          frame.image_file);
    } catch (const InputError& e) {
      bar.note(std::string("warning: ") + e.what());
      ++unusable;
      continue;
    }
    std::vector<Trial> trials(o.trials);
    for (int t = 0; t < o.trials; ++t)
      trials[t] = runTrial(map, image, *frame.ground_truth, o,
                           params.filter.seed + 1000003 * f + static_cast<uint64_t>(t));
    size_t good_here = 0;
    for (const Trial& t : trials) {
      position.push_back(t.position);
      angle.push_back(t.angle / kDegree);
      if (t.position < kGoodPosition && t.angle < kGoodAngle) ++good_here;
    }
    good += good_here;
    total += trials.size();
    images.push_back({{"time", frame.time_text}, {"good", good_here}, {"trials", trials.size()}});
  }
  if (total == 0) throw InputError(o.sequence + ": no readable image with ground truth");
  const double share = static_cast<double>(good) / static_cast<double>(total);
  const ErrorSummary p = summarize(position), a = summarize(angle);
  if (o.json) {
    const nlohmann::json j = {{"sequence", sequence.name},
                              {"offset_m", o.offset},
                              {"angle_deg", o.angle},
                              {"repeats", o.repeats},
                              {"trials", total},
                              {"success", share},
                              {"position_error_median_m", p.median},
                              {"rotation_error_median_deg", a.median},
                              {"unusable_images", unusable},
                              {"images", images}};
    std::printf("%s\n", textOf(j).c_str());
  } else {
    std::printf(
        "%s: start with an error of %.2f m and %.1f deg, %d updates with one image, %zu trials: "
        "%.1f %% end within 0.10 m and 3 deg (median error %.1f cm, %.2f deg)\n",
        sequence.name.c_str(), o.offset, o.angle, o.repeats, total, 100 * share, 100 * p.median,
        a.median);
  }
  return unusable == 0 ? kExitOk : kExitIncomplete;
}

}  // namespace

void addBasin(CLI::App* app, Action* action) {
  auto o = std::make_shared<BasinOptions>();
  CLI::App* c = app->add_subcommand(
      "basin",
      "start the filter with an error at single images and count how often it finds the pose");
  c->add_option("sequence", o->sequence, "sequence directory with ground truth")->required();
  c->add_option("--model", o->model, "model file; default: SEQUENCE/model.obj");
  c->add_option("--offset", o->offset,
                "distance of the start from the true position, m; default 0.2");
  c->add_option("--angle", o->angle,
                "angle between the start and the true orientation, degrees; default 3");
  c->add_option("--trials", o->trials, "number of starts per image; default 10");
  c->add_option("--repeats", o->repeats,
                "number of updates of the filter with the same image; default 5");
  c->add_flag("--no-mask", o->no_mask, "use no masks; default: the masks of the sequence are used");
  c->add_flag("--json", o->json, "print the result as JSON; default: as text");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
