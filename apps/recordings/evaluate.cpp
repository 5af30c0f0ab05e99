// edge-mcl evaluate: computes the errors of a trajectory against a reference, without alignment.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/trajectory_plot.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"

namespace edge_mcl {

namespace {

struct EvaluateOptions {
  std::string estimate, reference, plot;
  double max_dt = 0.005, position_limit = 0.10, rotation_limit = 3.0;
  bool json = false;
};

nlohmann::json jsonOf(const ErrorSummary& s) {
  return {{"mean", s.mean}, {"median", s.median}, {"rmse", s.rmse}, {"p90", s.p90}, {"max", s.max}};
}

void print(const char* name, const char* unit, double factor, const ErrorSummary& s) {
  std::printf("%-28s mean %8.3f  median %8.3f  rmse %8.3f  p90 %8.3f  max %8.3f %s\n", name,
              factor * s.mean, factor * s.median, factor * s.rmse, factor * s.p90, factor * s.max,
              unit);
}

int run(const EvaluateOptions& o) {
  const Trajectory estimate = readTrajectory(o.estimate), reference = readTrajectory(o.reference);
  if (reference.empty()) throw InputError(o.reference + ": the file has no poses");
  const TrajectoryErrors e =
      evaluateTrajectory(estimate, reference, o.max_dt, o.position_limit, o.rotation_limit);
  if (!o.plot.empty()) writePicture(o.plot, drawTrajectories(estimate, reference));
  // Without a pair of poses no errors are printed, because zeros would look like a perfect result.
  const ExitCode code = e.matched > 0 ? kExitOk : kExitIncomplete;
  if (o.json) {
    nlohmann::json j = {{"reference_poses", e.reference_poses}, {"matched", e.matched}};
    if (e.matched > 0)
      j.update({{"position_m", jsonOf(e.position_summary)},
                {"rotation_deg", jsonOf(e.rotation_summary)},
                {"relative_position_m", jsonOf(e.relative_position)},
                {"relative_rotation_deg", jsonOf(e.relative_rotation)},
                {"success_share", e.success_share},
                {"success_share_of_matched", e.success_share_of_matched}});
    std::printf("%s\n", textOf(j).c_str());
    return code;
  }
  std::printf("%zu reference poses, %zu matched within %g s\n", e.reference_poses, e.matched,
              o.max_dt);
  if (e.matched == 0) return code;
  print("absolute position", "cm", 100, e.position_summary);
  print("absolute rotation", "deg", 1, e.rotation_summary);
  print("relative position per step", "cm", 100, e.relative_position);
  print("relative rotation per step", "deg", 1, e.relative_rotation);
  std::printf(
      "within %g m and %g deg: %.1f %% of the matched poses, %.1f %% of the reference poses\n",
      o.position_limit, o.rotation_limit, 100 * e.success_share_of_matched, 100 * e.success_share);
  return code;
}

}  // namespace

void addEvaluate(CLI::App* app, Action* action) {
  auto o = std::make_shared<EvaluateOptions>();
  CLI::App* c = app->add_subcommand(
      "evaluate", "compute the errors of a trajectory against a reference, without alignment");
  c->add_option("estimate", o->estimate, "file with the trajectory, in TUM format")->required();
  c->add_option("reference", o->reference, "file with the ground truth, in TUM format")->required();
  c->add_option("--plot", o->plot, "file for a picture of both trajectories; default: no picture");
  c->add_option("--max-dt", o->max_dt,
                "largest time difference between two poses that are compared, s; default 0.005");
  c->add_option("--position-limit", o->position_limit,
                "a pose is right when its position error is below this, m; default 0.1");
  c->add_option("--rotation-limit", o->rotation_limit,
                "a pose is right when also its rotation error is below this, degrees; default 3");
  c->add_flag("--json", o->json, "print the result as JSON; default: as text");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
