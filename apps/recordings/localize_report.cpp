#include "apps/recordings/localize_report.h"

#include <algorithm>
#include <cstdio>

#include "edge_mcl/core/recordings/trajectory_evaluation.h"

namespace edge_mcl {

namespace {

nlohmann::json jsonOf(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json jsonOf(const ObjectState& o) {
  nlohmann::json j{{"number", o.number},
                   {"low", jsonOf(o.box.min())},
                   {"high", jsonOf(o.box.max())},
                   {"velocity", jsonOf(o.velocity)},
                   {"position_sigma", o.position_sigma},
                   {"moving", o.is_moving},
                   {"in_view", o.is_in_view},
                   {"first_seen", o.first_seen},
                   {"last_seen", o.last_seen}};
  if (!o.is_moving) j["still_since"] = o.still_since;
  return j;
}

nlohmann::json jsonOf(const LiveResult& r, const std::string& time, double reading_ms) {
  const UpdateReport& u = r.report;
  const StageTimes& t = r.image_times;
  const Matrix6 c = covarianceInMapAxes(r.estimate);
  nlohmann::json j{{"time", time},
                   {"state", nameOf(r.state)},
                   {"problem", r.problem},
                   {"updated", r.updated},
                   {"ess", u.effective_sample_size},
                   {"tempering", u.tempering},
                   {"visible_lines", u.visible_lines},
                   {"visible_samples", u.visible_samples},
                   {"match_ratio", r.match_ratio},
                   {"log_likelihood", u.log_likelihood},
                   {"evidence_per_line", u.evidence_per_line},
                   {"masked_share", r.masked_share},
                   {"foreign_share", r.foreign_share},
                   {"foreign_agreement", r.foreign_agreement},
                   {"depth_points", u.depth_points},
                   {"depth_agreement", u.depth_agreement},
                   {"depth_bias", u.depth_bias},
                   {"probability", r.probability},
                   {"log_odds", r.log_odds},
                   {"contrast", u.contrast},
                   {"line_sigma", u.line_sigma},
                   {"calibration",
                    {{"focal_error", u.focal_error},
                     {"centre_error", {u.centre_error.x(), u.centre_error.y()}}}},
                   {"odometry",
                    {{"scale_error", r.odometry.scaleError()},
                     {"turn_rate", r.odometry.turnRate().norm()},
                     {"noise_factor", r.odometry.noiseFactor()}}},
                   {"injected_share", u.injected_share},
                   {"refined_modes", u.refined_modes},
                   {"covariance", std::vector<double>(c.data(), c.data() + 36)}};
  j["ms"] = {{"reading", reading_ms},
             {"foreign", r.foreign_ms},
             {"objects", r.objects_ms},
             {"edges", t.edges},
             {"field", t.field},
             {"table", t.table},
             {"likelihood", u.likelihood_ms},
             {"refinement", u.refinement_ms},
             {"filter", u.total_ms},
             {"update", t.edges + t.field + t.table + u.total_ms}};
  for (const ObjectState& object : r.objects) j["objects"].push_back(jsonOf(object));
  if (r.clusters.empty()) return j;
  j["search"] = {{"keyframes", r.search_keyframes}, {"ms", r.search_ms}};
  for (const PoseCluster& cluster : r.clusters)
    j["search"]["clusters"].push_back({{"probability", cluster.probability},
                                       {"score", cluster.score},
                                       {"pose", formatPose(time, cluster.pose)}});
  if (r.next_view)
    j["search"]["next_view"] = {{"difference", r.next_view->difference},
                                {"if_first", formatPose(time, r.next_view->first)},
                                {"if_second", formatPose(time, r.next_view->second)}};
  return j;
}

/// @param truth in order of time
size_t countWithTruth(const std::vector<double>& times, const Trajectory& truth) {
  constexpr double kTolerance = 0.005;  // s, the one of evaluateTrajectory
  return static_cast<size_t>(std::count_if(times.begin(), times.end(), [&](double time) {
    const auto first =
        std::lower_bound(truth.begin(), truth.end(), time - kTolerance,
                         [](const StampedPose& pose, double t) { return pose.time < t; });
    return first != truth.end() && first->time <= time + kTolerance;
  }));
}

}  // namespace

void LocalizeReport::add(const RecordedLocalizer& localizer, const std::string& time_text) {
  const LiveInput& input = localizer.input();
  const LiveResult& r = localizer.result();
  if (input.odometry) ++with_odometry_;
  // An image that is skipped because the robot rests has no problem.
  if (!r.updated && !r.problem.empty()) ++unusable_;
  if (r.late) return;
  if (r.foreign_agreement >= 0) {
    ++with_foreign_;
    agreeing_ += r.depth_agrees ? 1 : 0;
    foreign_share_ += r.foreign_share;
  }
  for (const ObjectState& object : r.objects) objects_.insert(object.number);
  image_times_.push_back(input.time);
  ++states_[nameOf(r.state)];
  if (localizer.localizer().isInitialized())
    estimate_.push_back({input.time, time_text, r.estimate.mean});
  images_.push_back(jsonOf(r, time_text, localizer.readingMs()));
  if (r.updated) update_ms_.push_back(images_.back()["ms"]["update"].get<double>());
}

nlohmann::json LocalizeReport::summary(const OpenedRecording& opened,
                                       const RecordedInput& recording) const {
  const Parameters& params = opened.map->params();
  const ErrorSummary timing = summarize(update_ms_);
  nlohmann::json summary{{"recording", opened.name},
                         {"model", opened.model_file},
                         {"backend", opened.map->backend().name()},
                         {"likelihood", params.get("likelihood.model")},
                         {"cues", params.get("likelihood.cues")},
                         {"particles", params.filter.particles},
                         {"seed", params.filter.seed},
                         {"images", recording.imageCount()},
                         {"unusable_images", unusable_},
                         {"images_with_odometry", with_odometry_},
                         {"states", states_},
                         {"trajectory", opened.trajectory_pose},
                         {"update_ms_median", timing.median},
                         {"update_ms_p90", timing.p90}};
  if (params.tracking.mask_by_depth)
    summary["masks_by_depth"] = {
        {"images", with_foreign_},
        {"agreeing", agreeing_},
        {"mean_share", foreign_share_ / static_cast<double>(std::max<size_t>(1, with_foreign_))}};
  if (params.tracking.mask_by_depth) summary["foreign_objects"] = objects_.size();
  const TrajectoryErrors errors = evaluateTrajectory(estimate_, recording.truth());
  if (errors.matched == 0) return summary;
  // Ground truth often has a rate of its own, so the share is that of images with ground truth,
  // whether they have a pose or not.
  const size_t with_truth =
      std::max(countWithTruth(image_times_, recording.truth()), errors.matched);
  summary["images_with_truth"] = with_truth;
  summary["position_error_median_m"] = errors.position_summary.median;
  summary["rotation_error_median_deg"] = errors.rotation_summary.median;
  summary["within_10cm_3deg"] = errors.success_share_of_matched *
                                static_cast<double>(errors.matched) /
                                static_cast<double>(with_truth);
  return summary;
}

std::string textOfSummary(const nlohmann::json& s) {
  char line[512];
  std::snprintf(line, sizeof line,
                "%s: %zu images, %zu not used, %d particles, %s, update median %.1f ms\n",
                s["recording"].get<std::string>().c_str(), s["images"].get<size_t>(),
                s["unusable_images"].get<size_t>(), s["particles"].get<int>(),
                s["backend"].get<std::string>().c_str(), s["update_ms_median"].get<double>());
  std::string text = line;
  if (s.contains("masks_by_depth")) {
    const nlohmann::json& m = s["masks_by_depth"];
    const auto images = m["images"].get<size_t>(), agreeing = m["agreeing"].get<size_t>();
    std::snprintf(
        line, sizeof line,
        "masks by depth: depth lies on the model in %zu of %zu images; mean share %.1f %%\n",
        agreeing, images, 100 * m["mean_share"].get<double>());
    text += line;
    if (2 * agreeing < images || images == 0)
      text +=
          "  Depth and model seldom agree: check depth_scale, the mounting of the depth camera, "
          "and the pose.\n";
  }
  if (s.contains("foreign_objects") && s["foreign_objects"] > 0)
    text +=
        "objects that are not in the model: " + std::to_string(s["foreign_objects"].get<size_t>()) +
        " (--stats has them)\n";
  text += "states:";
  for (const auto& [state, count] : s["states"].items())
    text += " " + state + " " + std::to_string(count.get<size_t>());
  text += "\n";
  if (!s.contains("within_10cm_3deg")) return text;
  std::snprintf(line, sizeof line,
                "error: median %.2f cm, %.2f deg; within 10 cm and 3 deg: %.1f %% of %zu images "
                "with truth\n",
                100 * s["position_error_median_m"].get<double>(),
                s["rotation_error_median_deg"].get<double>(),
                100 * s["within_10cm_3deg"].get<double>(), s["images_with_truth"].get<size_t>());
  return text + line;
}

}  // namespace edge_mcl
