#include "apps/recordings/localize_recorded.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"

namespace edge_mcl {

namespace {

nlohmann::json jsonOf(const LiveResult& r, const std::string& time) {
  const Matrix6 c = covarianceInMapAxes(r.estimate);
  return {{"time", time},
          {"state", nameOf(r.state)},
          {"problem", r.problem},
          {"updated", r.updated},
          {"ess", r.report.effective_sample_size},
          {"match_ratio", r.match_ratio},
          {"evidence_per_line", r.report.evidence_per_line},
          {"visible_lines", r.report.visible_lines},
          {"depth_points", r.report.depth_points},
          {"depth_agreement", r.report.depth_agreement},
          {"masked_share", r.masked_share},
          {"update_ms",
           r.image_times.edges + r.image_times.field + r.image_times.table + r.report.total_ms},
          {"covariance", std::vector<double>(c.data(), c.data() + 36)}};
}

/// @param truth in order of time.
size_t countWithTruth(const std::vector<double>& times, const Trajectory& truth) {
  constexpr double kTolerance = 0.005;  // s, as for poses
  return static_cast<size_t>(std::count_if(times.begin(), times.end(), [&](double time) {
    const auto first =
        std::lower_bound(truth.begin(), truth.end(), time - kTolerance,
                         [](const StampedPose& pose, double t) { return pose.time < t; });
    return first != truth.end() && first->time <= time + kTolerance;
  }));
}

}  // namespace

int localizeRecorded(const LocalizeOptions& o) {
  OpenedRecording opened = openRecording(o, false);
  RecordedInput& recording = *opened.input;
  const std::shared_ptr<LocalizationMap>& map = opened.map;
  LiveLocalizer localizer(map);
  if (opened.start)
    localizer.setPose(*opened.start);
  else
    localizer.searchEverywhere();
  const std::optional<Eigen::Vector3d>& up = opened.up;
  std::ofstream out(o.out);
  if (!out) throw InputError(o.out + ": cannot be written");
  out << "# T_map_base by edge-mcl localize: timestamp tx ty tz qx qy qz qw\n";
  if (!o.overlay.empty()) makeDirectory(o.overlay);
  Trajectory estimate;
  nlohmann::json images = nlohmann::json::array();
  std::map<std::string, size_t> states;
  std::vector<double> update_ms, image_times;
  size_t unusable = 0, with_odometry = 0;
  ProgressBar bar("localize", recording.imageCount());
  LiveInput input;
  std::string problem;
  while (recording.next(&input, &problem)) {
    bar.advance();
    if (up && images.empty()) {
      input.up.emplace();
      input.up->up_base = *up;
    }
    if (input.odometry) ++with_odometry;
    LiveResult r = localizer.process(input);
    input.up.reset();
    if (!problem.empty()) r.problem = problem;
    if (!r.problem.empty()) bar.note("warning: " + r.problem);
    // One of a robot at rest is not needed, and has no problem.
    if (!r.updated && !r.problem.empty()) ++unusable;
    if (r.late) continue;
    image_times.push_back(input.time);
    char time[32];
    std::snprintf(time, sizeof time, "%.6f", input.time);
    if (localizer.isInitialized()) {
      out << formatPose(time, r.estimate.mean) << std::endl;
      estimate.push_back({input.time, time, r.estimate.mean});
    }
    if (!out) throw InputError(o.out + ": cannot be written (disk full?)");
    ++states[nameOf(r.state)];
    images.push_back(jsonOf(r, time));
    if (r.updated) update_ms.push_back(images.back()["update_ms"].get<double>());
    if (!o.overlay.empty() && !r.images.empty() && localizer.isInitialized()) {
      const std::string file = o.overlay + "/" + time + ".png";
      writePicture(file, drawOverlay(*map, *r.images.front(),
                                     r.estimate.mean * input.views.front().T_base_camera));
    }
  }
  nlohmann::json summary{{"recording", o.recording},
                         {"model", o.model},
                         {"backend", map->backend().name()},
                         {"images", recording.imageCount()},
                         {"unusable_images", unusable},
                         {"images_with_odometry", with_odometry},
                         {"states", states},
                         {"update_ms_median", summarize(update_ms).median}};
  const TrajectoryErrors errors = evaluateTrajectory(estimate, recording.truth());
  const size_t with_truth = countWithTruth(image_times, recording.truth());
  if (errors.matched > 0) {
    summary["images_with_truth"] = with_truth;
    summary["position_error_median_m"] = errors.position_summary.median;
    summary["rotation_error_median_deg"] = errors.rotation_summary.median;
    // Of the images, with a pose or without; truth often has a rate of its own.
    summary["within_10cm_3deg"] = errors.success_share_of_matched *
                                  static_cast<double>(errors.matched) /
                                  static_cast<double>(std::max(with_truth, errors.matched));
  }
  if (!o.stats.empty()) writeJson(o.stats, {{"summary", summary}, {"images", images}});
  if (o.json) {
    std::printf("%s\n", textOf(summary).c_str());
  } else {
    std::printf("%s: %zu images, %zu not used, update median %.1f ms;", o.recording.c_str(),
                recording.imageCount(), unusable, summarize(update_ms).median);
    for (const auto& [state, count] : states) std::printf(" %s %zu", state.c_str(), count);
    std::printf("\n");
    if (errors.matched > 0)
      std::printf(
          "error: median %.2f cm, %.2f deg; within 10 cm and 3 deg: %.1f %% of %zu images with "
          "truth\n",
          100 * errors.position_summary.median, errors.rotation_summary.median,
          100 * summary["within_10cm_3deg"].get<double>(), with_truth);
    std::printf("trajectory of the base: %s\n", o.out.c_str());
  }
  if (!o.plot.empty()) writePicture(o.plot, drawTrajectories(estimate, recording.truth()));
  if (with_odometry == 0)
    std::fprintf(stderr,
                 "warning: %s: no odometry in it for any image; steady motion was assumed\n",
                 o.recording.c_str());
  if (estimate.empty()) sayThatNoPoseWasFound(o.recording);
  const bool complete = unusable == 0 && !estimate.empty() && recording.damage().empty();
  return complete ? kExitOk : kExitIncomplete;
}

}  // namespace edge_mcl
