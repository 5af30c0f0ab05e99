#include "localize_bag.h"

#include "edge_mcl/core/error.h"

#ifdef EDGE_MCL_HAS_ROS
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "edge_mcl/core/overlay.h"
#include "edge_mcl/core/trajectory_evaluation.h"
#include "edge_mcl/mrpt_plugins/backend_choice.h"
#include "edge_mcl/nodes/bag_reader.h"
#include "output_files.h"
#include "progress_bar.h"

namespace edge_mcl {

namespace {

BagTopics parseTopics(const LocalizeOptions& o) {
  BagTopics topics;
  std::map<std::string, std::string*> fields{{"image", &topics.image},
                                             {"camera_info", &topics.camera_info},
                                             {"mask", &topics.mask},
                                             {"depth", &topics.depth},
                                             {"depth_info", &topics.depth_info},
                                             {"truth", &topics.truth},
                                             {"initialpose", &topics.initial_pose},
                                             {"odom_frame", &topics.odom_frame},
                                             {"base_frame", &topics.base_frame}};
  std::istringstream list(o.topics);
  for (std::string entry; std::getline(list, entry, ',');) {
    const auto equals = entry.find('=');
    const auto field = fields.find(entry.substr(0, equals));
    if (equals == std::string::npos || field == fields.end())
      throw ParameterError("--topics " + entry +
                           ": NAME=TOPIC expected, NAME one of image, camera_info, mask, depth, "
                           "depth_info, truth, "
                           "initialpose, odom_frame, base_frame");
    *field->second = entry.substr(equals + 1);
  }
  if (o.no_mask) topics.mask.clear();
  return topics;
}

PoseGaussian initialPose(const LocalizeOptions& o, const BagReader& bag) {
  PoseGaussian pose;
  if (!o.initial_pose.empty()) {
    double v[6];
    char rest = 0;
    if (std::sscanf(o.initial_pose.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%c", &v[0], &v[1], &v[2], &v[3],
                    &v[4], &v[5], &rest) != 6)
      throw ParameterError("--initial-pose " + o.initial_pose +
                           ": x,y,z,roll,pitch,yaw expected (metres, degrees)");
    const double degree = M_PI / 180;
    pose.mean.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    pose.mean.linear() = rotationFromAngles(v[3] * degree, v[4] * degree, v[5] * degree);
  } else if (bag.initialPose()) {
    pose = *bag.initialPose();
  } else {
    throw InputError(o.sequence + ": no initial pose in it; give one with --initial-pose");
  }
  if (!o.initial_std.empty() || pose.covariance.isZero()) {
    const auto [metres, radians] = parseInitialStd(o.initial_std.empty() ? "0.1,3" : o.initial_std);
    pose.covariance.setZero();
    pose.covariance.diagonal().head<3>().setConstant(metres * metres);
    pose.covariance.diagonal().tail<3>().setConstant(radians * radians);
  }
  return pose;
}

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

}  // namespace

int localizeBag(const LocalizeOptions& o) {
  const Parameters params = parametersOf(o);
  if (o.model.empty()) throw InputError(o.sequence + ": name the model with --model");
  BagTopics topics = parseTopics(o);
  if (params.likelihood.cues == Cues::kEdges) topics.depth.clear();
  BagReader bag(o.sequence, topics);
  auto map = std::make_shared<LocalizationMap>(o.model, params);
  chooseBackend(map.get());
  for (const std::string& w : map->mesh().report.warnings)
    std::fprintf(stderr, "warning: %s: %s\n", o.model.c_str(), w.c_str());
  LiveLocalizer localizer(map);
  const std::optional<Eigen::Vector3d> up = parseUp(o.up);
  if (o.global || up)
    localizer.searchEverywhere();
  else
    localizer.setPose(initialPose(o, bag));
  std::ofstream out(o.out);
  if (!out) throw InputError(o.out + ": cannot be written");
  out << "# T_map_base by edge-mcl localize: timestamp tx ty tz qx qy qz qw\n";
  if (!o.overlay.empty()) makeDirectory(o.overlay);
  Trajectory estimate;
  nlohmann::json images = nlohmann::json::array();
  std::map<std::string, size_t> states;
  std::vector<double> update_ms;
  size_t unusable = 0;
  ProgressBar bar("localize", bag.imageCount());
  LiveInput input;
  std::string problem;
  while (bag.next(&input, &problem)) {
    bar.advance();
    if (up && images.empty()) {
      input.up.emplace();
      input.up->up_base = *up;
    }
    LiveResult r = localizer.process(input);
    input.up.reset();
    if (!problem.empty()) r.problem = problem;
    if (!r.problem.empty()) bar.note("warning: " + r.problem);
    if (!r.updated) ++unusable;
    if (r.late) continue;
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
      if (!cv::imwrite(file, drawOverlay(*map, *r.images.front(),
                                         r.estimate.mean * input.views.front().T_base_camera)))
        throw InputError(file + ": cannot be written");
    }
  }
  if (!o.plot.empty() && !cv::imwrite(o.plot, drawTrajectories(estimate, bag.truth())))
    throw InputError(o.plot + ": cannot be written");
  nlohmann::json summary{{"bag", o.sequence},
                         {"model", o.model},
                         {"backend", map->backend().name()},
                         {"images", bag.imageCount()},
                         {"unusable_images", unusable},
                         {"states", states},
                         {"update_ms_median", summarize(update_ms).median}};
  TrajectoryErrors errors;
  if (!bag.truth().empty() && !estimate.empty()) {
    errors = evaluateTrajectory(estimate, bag.truth());
    summary["position_error_median_m"] = errors.position_summary.median;
    summary["rotation_error_median_deg"] = errors.rotation_summary.median;
    summary["within_10cm_3deg"] = errors.success_share;
  }
  if (!o.stats.empty()) writeJson(o.stats, {{"summary", summary}, {"images", images}});
  if (o.json) {
    std::printf("%s\n", summary.dump(1).c_str());
  } else {
    std::printf("%s: %zu images, %zu not used, update median %.1f ms;", o.sequence.c_str(),
                bag.imageCount(), unusable, summarize(update_ms).median);
    for (const auto& [state, count] : states) std::printf(" %s %zu", state.c_str(), count);
    std::printf("\n");
    if (!bag.truth().empty() && !estimate.empty())
      std::printf("error: median %.2f cm, %.2f deg; within 10 cm and 3 deg: %.1f %%\n",
                  100 * errors.position_summary.median, errors.rotation_summary.median,
                  100 * errors.success_share);
    std::printf("trajectory of the base: %s\n", o.out.c_str());
  }
  return unusable > 0 ? kExitIncomplete : kExitOk;
}

}  // namespace edge_mcl

#else

namespace edge_mcl {

int localizeBag(const LocalizeOptions& o) {
  throw InputError(o.sequence + ": this build has no ROS, so it reads no bags");
}

}  // namespace edge_mcl

#endif
