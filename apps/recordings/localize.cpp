// edge-mcl localize: a sequence and a model in, a trajectory with covariance out.
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "apps/recordings/localize_recorded.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/localization/backend_choice.h"
#include "edge_mcl/localization/recorded/sequence_localizer.h"

namespace edge_mcl {

namespace {

nlohmann::json jsonOf(const LiveResult& r, const SequenceFrame& frame, double reading_ms) {
  nlohmann::json j;
  j["time"] = frame.time_text;
  j["updated"] = r.updated;
  j["state"] = nameOf(r.state);
  if (!r.clusters.empty()) {
    j["search"] = {{"keyframes", r.search_keyframes}, {"ms", r.search_ms}};
    for (const PoseCluster& c : r.clusters)
      j["search"]["clusters"].push_back(
          {{"weight", c.weight}, {"pose", formatPose(frame.time_text, c.pose)}});
  }
  if (!r.problem.empty()) j["problem"] = r.problem;
  const UpdateReport& u = r.report;
  j["ess"] = u.effective_sample_size;
  j["tempering"] = u.tempering;
  j["visible_lines"] = u.visible_lines;
  j["visible_samples"] = u.visible_samples;
  j["match_ratio"] = r.match_ratio;
  j["log_likelihood"] = u.log_likelihood;
  j["evidence_per_line"] = u.evidence_per_line;
  if (u.depth_points > 0) {
    j["depth_points"] = u.depth_points;
    j["depth_agreement"] = u.depth_agreement;
    j["depth_bias"] = u.depth_bias;
  }
  j["injected_share"] = u.injected_share;
  j["refined_modes"] = u.refined_modes;
  j["ms"] = {
      {"reading", reading_ms},
      {"edges", r.image_times.edges},
      {"field", r.image_times.field},
      {"table", r.image_times.table},
      {"likelihood", u.likelihood_ms},
      {"refinement", u.refinement_ms},
      {"filter", u.total_ms},
      {"update", r.image_times.edges + r.image_times.field + r.image_times.table + u.total_ms}};
  const Matrix6 c = covarianceInMapAxes(r.estimate);
  std::vector<double> covariance(c.data(), c.data() + 36);
  j["covariance"] = covariance;
  return j;
}

/// Reference poses of the sequence, for the summary and the plot.
Trajectory truthOf(const Sequence& sequence) {
  Trajectory truth;
  for (const SequenceFrame& f : sequence.frames)
    if (f.ground_truth) truth.push_back({f.time, f.time_text, *f.ground_truth});
  return truth;
}

int run(const LocalizeOptions& o) {
  for (const std::string& file : {o.out, o.stats, o.plot}) checkOutput(file);
  if (kindOf(o.recording) != RecordingKind::kDirectory) return localizeRecorded(o);
  checkOptionsOfDirectory(o);
  const Parameters params = parametersOf(o);
  Sequence sequence = readSequence(o.recording);
  if (!o.masks.empty()) useMasks(o.masks, &sequence);
  for (const std::string& w : sequence.warnings) std::fprintf(stderr, "warning: %s\n", w.c_str());
  const std::string model = o.model.empty() ? sequence.model_file : o.model;
  if (model.empty())
    throw InputError(o.recording + ": no model.obj in it; name the model with --model");
  if (params.likelihood.cues != Cues::kEdges && sequence.depths.empty())
    throw InputError(o.recording + ": depth asked for, but there is no depth.txt in it");
  LocalizationMap map(model, params);
  chooseBackend(&map);
  for (const std::string& w : map.mesh().report.warnings)
    std::fprintf(stderr, "warning: %s: %s\n", model.c_str(), w.c_str());
  SequenceLocalizer localizer(map, sequence, !o.no_mask);
  const bool global = o.global || !o.up.empty();
  if (!global && !sequence.initial_pose)
    throw InputError(o.recording +
                     "/sequence.yaml: no initial_pose in it; look for it with --global");
  if (global) localizer.searchEverywhere(parseUp(o.up));
  if (!o.initial_std.empty()) {
    const auto [metres, radians] = parseInitialStd(o.initial_std);
    localizer.setInitialSpread(metres, radians);
  }

  std::ofstream out(o.out);
  if (!out) throw InputError(o.out + ": cannot be written");
  out << "# T_map_camera by edge-mcl localize: timestamp tx ty tz qx qy qz qw\n";
  if (!o.overlay.empty()) makeDirectory(o.overlay);
  nlohmann::json per_image = nlohmann::json::array();
  std::vector<double> update_ms;
  size_t unusable = 0;
  std::map<std::string, size_t> states;
  Trajectory estimate;
  std::string last_problem;
  ProgressBar bar(sequence.name, localizer.frameCount());
  for (const SequenceFrame& frame : sequence.frames) {
    const LiveResult r = localizer.step();
    if (!r.updated && !r.problem.empty()) ++unusable;
    ++states[nameOf(r.state)];
    if (!r.problem.empty() && r.problem != last_problem) bar.note("warning: " + r.problem);
    last_problem = r.problem;
    if (r.relocalized) bar.note("found the pose at " + frame.time_text);
    // Flushed line by line: an interrupted run keeps what it has computed. A pose that is not known
    // is not written.
    if (localizer.localizer().isInitialized()) {
      out << formatPose(frame.time_text, r.estimate.mean) << std::endl;
      estimate.push_back({frame.time, frame.time_text, r.estimate.mean});
    }
    if (!out) throw InputError(o.out + ": cannot be written (disk full?)");
    nlohmann::json entry = jsonOf(r, frame, localizer.readingMs());
    if (r.updated) update_ms.push_back(entry["ms"]["update"].get<double>());
    per_image.push_back(std::move(entry));
    if (!o.overlay.empty() && !r.images.empty() && localizer.localizer().isInitialized()) {
      const std::string file = o.overlay + "/" + frame.time_text + ".png";
      writePicture(file, drawOverlay(map, *r.images.front(), r.estimate.mean));
    }
    bar.advance();
  }

  const Trajectory truth = truthOf(sequence);
  const ErrorSummary timing = summarize(update_ms);
  nlohmann::json summary;
  summary["sequence"] = sequence.name;
  summary["model"] = model;
  summary["backend"] = map.backend().name();
  summary["likelihood"] = params.get("likelihood.model");
  summary["cues"] = params.get("likelihood.cues");
  summary["particles"] = params.filter.particles;
  summary["seed"] = params.filter.seed;
  summary["images"] = sequence.frames.size();
  summary["unusable_images"] = unusable;
  summary["states"] = states;
  summary["update_ms_median"] = timing.median;
  summary["update_ms_p90"] = timing.p90;
  if (!truth.empty() && !estimate.empty()) {
    const TrajectoryErrors e = evaluateTrajectory(estimate, truth);
    if (e.matched > 0) {
      summary["position_error_median_m"] = e.position_summary.median;
      summary["rotation_error_median_deg"] = e.rotation_summary.median;
      summary["within_10cm_3deg"] = e.success_share;
    }
  }
  if (!o.stats.empty()) writeJson(o.stats, {{"summary", summary}, {"images", per_image}});
  if (o.json) {
    std::printf("%s\n", textOf(summary).c_str());
  } else {
    std::printf("%s: %zu images, %zu unusable, %d particles, %s, update median %.1f ms\n",
                sequence.name.c_str(), sequence.frames.size(), unusable, params.filter.particles,
                map.backend().name().c_str(), timing.median);
    std::printf("states:");
    for (const auto& [state, count] : states) std::printf(" %s %zu", state.c_str(), count);
    std::printf("\n");
    if (summary.contains("within_10cm_3deg"))
      std::printf("error: median %.2f cm, %.2f deg; within 10 cm and 3 deg: %.1f %%\n",
                  100 * summary["position_error_median_m"].get<double>(),
                  summary["rotation_error_median_deg"].get<double>(),
                  100 * summary["within_10cm_3deg"].get<double>());
    std::printf("trajectory: %s\n", o.out.c_str());
  }
  if (!o.plot.empty()) writePicture(o.plot, drawTrajectories(estimate, truth));
  if (estimate.empty()) sayThatNoPoseWasFound(sequence.name);
  return unusable > 0 || estimate.empty() ? kExitIncomplete : kExitOk;
}

}  // namespace

void addLocalize(CLI::App* app, Action* action) {
  auto o = std::make_shared<LocalizeOptions>();
  CLI::App* c = app->add_subcommand(
      "localize", "track a recorded sequence, a ROS bag or a rawlog in its 3D model");
  o->addTo(c);
  c->add_option("--out", o->out, "trajectory to write (TUM format)");
  c->add_option("--stats", o->stats, "JSON file with timings, ESS, covariance per image");
  c->add_option("--overlay", o->overlay,
                "directory for pictures: model edges green, image edges blue, normals red");
  c->add_option("--plot", o->plot, "picture of the trajectory");
  c->add_flag("--json", o->json, "print the summary as JSON");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
