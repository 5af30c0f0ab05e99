// edge-mcl align: finds where a model lies in the coordinates of another system, for example a
// SLAM.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "apps/recordings/align_points.h"
#include "apps/recordings/placement.h"
#include "apps/recordings/recording_options.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/map_frame.h"
#include "edge_mcl/core/recordings/similarity_fit.h"
#include "edge_mcl/localization/recorded/recorded_localizer.h"

namespace edge_mcl {

namespace {

struct AlignOptions : RecordingOptions {
  std::string poses, points, out;
  bool keep_scale = false, json = false;
};

/// The pose at a time, between the two nearest poses; none in gaps of more than 0.2 s.
std::optional<Pose> poseAt(const Trajectory& poses, double time) {
  constexpr double kLargestGap = 0.2, kSame = 0.005;  // s
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time,
                       [](const StampedPose& pose, double t) { return pose.time < t; });
  for (const auto& near : {after, after == poses.begin() ? poses.end() : after - 1})
    if (near != poses.end() && std::abs(near->time - time) <= kSame) return near->pose;
  if (after == poses.begin() || after == poses.end()) return std::nullopt;
  const StampedPose &a = *(after - 1), &b = *after;
  if (b.time - a.time > kLargestGap) return std::nullopt;
  const double share = (time - a.time) / (b.time - a.time);
  return a.pose * expSe3(share * logSe3(a.pose.inverse() * b.pose));
}

/// A recording whose odometry is that of the other system, or none: a SLAM with one camera does not
/// know the metre.
class OtherOdometry : public RecordedInput {
 public:
  /// @param poses null: no odometry. They must outlive this object.
  OtherOdometry(std::unique_ptr<RecordedInput> input, const Trajectory* poses)
      : input_(std::move(input)), poses_(poses) {}
  size_t imageCount() const override { return input_->imageCount(); }
  const std::optional<PoseGaussian>& initialPose() const override { return input_->initialPose(); }
  const Trajectory& truth() const override { return input_->truth(); }
  bool next(LiveInput* input, std::string* problem) override {
    if (!input_->next(input, problem)) return false;
    input->odometry = poses_ == nullptr ? std::nullopt : poseAt(*poses_, input->time);
    return true;
  }

 private:
  std::unique_ptr<RecordedInput> input_;
  const Trajectory* poses_;
};

struct Pairs {
  std::vector<PosePair> pairs;  // T_model_*, and the pose in the other system
  size_t images = 0, tracked = 0;
};

/// Localizes the recording in the model. @param other poses of the other system.
/// @param is_metric they serve as odometry. @param most number of images; 0: all.
Pairs localize(const AlignOptions& o, const Trajectory& other, bool is_metric, size_t most) {
  OpenedRecording opened = openRecording(o, false);
  opened.input =
      std::make_unique<OtherOdometry>(std::move(opened.input), is_metric ? &other : nullptr);
  RecordedLocalizer localizer(opened.map, std::move(opened.input), opened.start);
  Pairs result;
  ProgressBar bar(opened.name, localizer.recording().imageCount());
  while ((most == 0 || result.images < most) && localizer.next()) {
    bar.advance();
    ++result.images;
    const LiveResult& r = localizer.result();
    if (r.late || r.state != LocalizerState::kTracking) continue;
    ++result.tracked;
    const auto there = poseAt(other, localizer.input().time);
    if (!there) continue;
    PosePair pair;
    pair.from = r.estimate.mean;
    pair.from.translation() += opened.origin;
    pair.to = *there;
    result.pairs.push_back(pair);
  }
  return result;
}

/// Poses of the other system: a file, or the odometry of the recording.
Trajectory otherPoses(const AlignOptions& o) {
  if (!o.poses.empty()) return readTrajectory(o.poses);
  Trajectory poses;
  const std::unique_ptr<RecordedInput> input = openInput(o);
  LiveInput moment;
  std::string problem;
  while (input->next(&moment, &problem))
    if (moment.odometry && (poses.empty() || moment.time > poses.back().time))
      poses.push_back({moment.time, "", *moment.odometry});
  if (poses.empty())
    throw InputError(o.recording +
                     ": the recording has no odometry; name a file with the poses of "
                     "the other system with --poses");
  return poses;
}

/// Units that a model file may have when it states none, in metres: the metre, millimetre,
/// centimetre, inch and foot. Those with which the model has the size of a building, the most usual
/// size first. @param size of the model in units of its file.
std::vector<double> usualScales(double size) {
  constexpr double kSmallest = 2, kUsual = 15, kLargest = 200;  // m
  std::vector<double> scales;
  for (const double scale : {1.0, 0.001, 0.01, 0.0254, 0.3048})
    if (scale * size >= kSmallest && scale * size <= kLargest) scales.push_back(scale);
  std::sort(scales.begin(), scales.end(), [&](double a, double b) {
    return std::abs(std::log(a * size / kUsual)) < std::abs(std::log(b * size / kUsual));
  });
  return scales;
}

/// What a first run is made with.
struct Beginning {
  double scale = 0;
  bool is_metric = true;  // the other poses serve as odometry
};

/// The scale with which most images of the beginning are tracked. The images look the same at every
/// scale, but the search assumes rooms and distances of usual size.
Beginning beginScale(const AlignOptions& o, const Trajectory& other) {
  constexpr size_t kImages = 60;
  AlignOptions as_metres = o;
  as_metres.parameters.set("map.scale", 1);
  const double size = LocalizationMap(o.model, as_metres.parameters.load()).mesh().diagonal();
  Beginning best;
  size_t most = 0;
  for (const bool is_metric : {true, false})
    for (const double scale : usualScales(size)) {
      AlignOptions tried = o;
      tried.parameters.set("map.scale", scale);
      size_t tracked = 0;
      try {
        tracked = localize(tried, other, is_metric, kImages).tracked;
      } catch (const InputError&) {
        continue;  // e.g. no free space at this size
      }
      std::fprintf(stderr, "note: with map.scale %g, %zu of the first %zu images are tracked\n",
                   scale, tracked, kImages);
      if (tracked <= most) continue;
      most = tracked;
      best = {scale, is_metric};
      if (tracked > kImages / 2) return best;
    }
  if (best.scale == 0)
    throw InputError(o.model +
                     ": the images are not found in the model at any usual scale; name "
                     "the scale with --set map.scale=..., or the initial pose");
  return best;
}

/// A usual unit that a fitted scale may be; the scale itself when there is none.
double usualUnit(double scale, double sigma) {
  // Errors of the positions are alike along a flight, so the stated deviation is a little small.
  constexpr double kLeast = 0.003, kSigmas = 3;
  for (const double unit : {1.0, 0.001, 0.01, 0.0254, 0.3048})
    if (std::abs(scale / unit - 1) < std::max(kLeast, kSigmas * sigma)) return unit;
  return scale;
}

/// One run after the other until the scale no longer changes.
struct Aligned {
  SimilarityFit fit;
  Pairs pairs;
  double scale = 1;  // map.scale of the run
};

Aligned align(AlignOptions o, const Trajectory& other) {
  const MapParameters given = parametersOf(o).map;
  Beginning begin{given.scale, true};
  if (given.scale <= 0 && !o.keep_scale) begin = beginScale(o, other);
  Aligned result;
  result.scale = begin.scale;
  bool is_fixed = o.keep_scale;
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    if (result.scale > 0) o.parameters.set("map.scale", result.scale);
    result.pairs = localize(o, other, begin.is_metric || round > 0, 0);
    if (result.pairs.pairs.empty() && result.pairs.tracked > 0)
      throw InputError((o.poses.empty() ? o.recording : o.poses) +
                       ": no pose has the time of a "
                       "tracked image; its poses are from " +
                       other.front().time_text + " to " + other.back().time_text + " s");
    result.fit = fitSimilarity(result.pairs.pairs, is_fixed);
    if (is_fixed) break;
    constexpr double kSettled = 0.02;
    const double fitted = result.scale * result.fit.similarity.scale;
    const double unit = usualUnit(fitted, result.fit.scale_sigma);
    const bool is_settled = std::abs(result.fit.similarity.scale - 1) < kSettled;
    // The last run has the unit that the scale must be, or fits the scale.
    if (is_settled && unit == fitted && (begin.is_metric || round > 0)) break;
    is_fixed = is_settled && unit != fitted;
    result.scale = is_settled ? unit : fitted;
  }
  return result;
}

int run(AlignOptions o) {
  checkOutput(o.out);
  if (!o.points.empty()) {
    if (!o.recording.empty() || !o.poses.empty() || !o.model.empty() || o.global)
      throw ParameterError("--points needs no recording, no --poses, no --model and no --global");
    return alignPoints(o.points, parametersOf(o).map, o.keep_scale, o.out, o.json);
  }
  if (o.recording.empty()) throw ParameterError("a recording, or --points, is missing");
  if (o.model.empty()) throw ParameterError("--model is missing");
  if (!o.initial_pose.empty() && parametersOf(o).map.scale <= 0 && !o.keep_scale)
    throw ParameterError(
        "--initial-pose needs the scale of the model: --set map.scale=..., or "
        "--keep-scale");
  if (o.initial_pose.empty() && o.up.empty()) o.global = true;
  const Trajectory other = otherPoses(o);
  const Aligned aligned = align(o, other);
  const double scale = aligned.scale > 0 ? aligned.scale : 1;
  const SimilarityFit& fit = aligned.fit;
  const Placement placement = placementOf(parametersOf(o).map, scale, fit.similarity);
  const std::string yaml = yamlOf(placement);
  if (!o.out.empty()) writeText(o.out, yaml);
  if (o.json) {
    nlohmann::json result =
        jsonOf(placement, fit.position_sigma, fit.rotation_sigma, fit.scale_sigma);
    result["images"] = aligned.pairs.images;
    result["tracked"] = aligned.pairs.tracked;
    result["used"] = fit.used;
    std::printf("%s\n", textOf(result).c_str());
  } else {
    std::printf(
        "%s%zu of %zu images tracked, %zu poses agree: %.1f cm, %.2f deg rms\n"
        "standard deviation: %.2f cm in the middle of the flight, %.3f deg, scale %.2g\n",
        yaml.c_str(), aligned.pairs.tracked, aligned.pairs.images, fit.used, 100 * fit.position_rms,
        fit.rotation_rms / kDegree, 100 * fit.position_sigma, fit.rotation_sigma / kDegree,
        fit.scale_sigma * placement.map.scale);
    const double used = aligned.scale > 0 ? aligned.scale : 1;
    std::fputs(transformLine(placement, used).c_str(), stdout);
  }
  // Poses of one body agree to some centimetres. An offset in time, or a body beside the camera,
  // does not.
  constexpr double kFarApart = 0.05, kTurned = 1.5 * kDegree;  // m, rad
  const bool is_poor = fit.position_rms > kFarApart || fit.rotation_rms > kTurned;
  if (is_poor)
    std::fprintf(
        stderr,
        "warning: the poses agree to %.0f cm and %.1f deg only; are the poses of %s those of "
        "another body (base, camera, IMU), or are their times shifted?\n",
        100 * fit.position_rms, fit.rotation_rms / kDegree,
        o.poses.empty() ? "the odometry" : o.poses.c_str());
  constexpr double kOtherBody = 10 * kDegree;
  if (fit.disagreement > kOtherBody)
    std::fprintf(stderr,
                 "warning: orientations and positions disagree by %.0f deg; are the poses those of "
                 "another body (base and camera)?\n",
                 fit.disagreement / kDegree);
  const bool is_good =
      2 * aligned.pairs.tracked > aligned.pairs.images && fit.disagreement < kOtherBody && !is_poor;
  return is_good ? kExitOk : kExitIncomplete;
}

}  // namespace

void addAlign(CLI::App* app, Action* action) {
  auto o = std::make_shared<AlignOptions>();
  CLI::App* c = app->add_subcommand(
      "align", "find where a model lies in the coordinates of another system (SLAM, odometry)");
  o->addTo(c);
  c->add_option(
      "--poses", o->poses,
      "trajectory of the other system with the times of the recording (TUM or EuRoC "
      "format), of the same body as the localizer's; default: the odometry of the recording");
  for (CLI::Option* option : c->get_options())
    if (option->get_positional()) option->required(false);
  c->add_option(
      "--points", o->points,
      "in place of a recording: a file with a line `x y z  X Y Z` for each point, first in "
      "the model file, then in the other system");
  c->add_flag("--keep-scale", o->keep_scale,
              "the scale of the model is right; default: it is fitted");
  c->add_option("--out", o->out, "YAML file with the parameters map.*, for --params");
  c->add_flag("--json", o->json, "print the result as JSON");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
