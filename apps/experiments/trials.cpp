// edge-mcl trials: flies many random flights with a fault. Counts how often the localizer finds the
// pose, and how often it reports `tracking` at a wrong pose.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/experiments/right_pose.h"
#include "apps/number_range.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/localization/map_factory.h"
#include "edge_mcl/localization/search/pose_sharpener.h"
#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/trial_flight.h"

namespace edge_mcl {

namespace {

// Fewer lines in view do not fix the pose, even if the search starts at the true pose.
constexpr double kFewLines = 3;

struct TrialOptions {
  std::string scenario, kind = "global", out;
  int count = 50, images = 0, event = 30;
  uint64_t first_seed = 1;
  double rate = 10, offset = 1, angle = 15, blackout = 10, drift = 1, imu_sigma_deg = 1;
  bool no_gravity = false, no_mask = false, depth = false, json = false;
  ParameterOptions parameters;
};

bool hasEvent(TrialKind kind) { return kind == TrialKind::kKidnap || kind == TrialKind::kBlackout; }

/// Number of images during which the event lasts: the images of the darkness, or 0.
int darkImages(const TrialOptions& o, TrialKind kind) {
  return kind == TrialKind::kBlackout ? static_cast<int>(std::lround(o.blackout * o.rate)) : 0;
}

/// Result of one flight.
struct Outcome {
  uint64_t seed = 0;
  /// Number of images, from the end of the event on, until the state is tracking; negative: never.
  int found_after = -1;
  bool wrong = false;        ///< tracking began at a wrong pose
  int tracking = 0;          ///< number of images with the state tracking
  int silent = 0;            ///< number of these images with a wrong pose
  int announced_after = -1;  ///< images from the event until not tracking; negative: never
  bool right_at_end = false;
  int rank = 0;    ///< rank of the true pose in the search at the end, 1: best; 0: not in it
  int looked = 0;  ///< number of images from the end of the event on
  int bare = 0;    ///< number of these with fewer than kFewLines unmasked lines, see isBare()
  double search_ms = 0;
  std::vector<double> nees;  ///< normalised squared error of every tracked image

  bool isFound() const { return found_after >= 0 && !wrong; }
  /// Whether more than half of the images show few lines.
  bool sawLittle() const { return 2 * bare > looked; }
};

LiveInput inputOf(const RecordedFrame& frame, const TrialFlight& flight, const TrialOptions& o,
                  RandomSource* random) {
  LiveInput input;
  input.time = frame.time;
  input.odometry = frame.odometry;
  LiveInput::CameraImage view;
  view.camera = flight.camera();
  view.image = frame.color;
  if (!o.no_mask) view.mask = frame.mask;
  view.origin = "image";
  if (o.depth) {
    LiveInput::Depth depth;
    depth.image = {view.camera, frame.depth, flight.depthScale(), "depth", std::nullopt};
    if (!view.mask.empty()) depth.image.mask = {view.mask, view.camera, Pose::Identity()};
    input.depths.push_back(std::move(depth));
  }
  input.images.push_back(std::move(view));
  if (!o.no_gravity) {
    const double sigma = o.imu_sigma_deg * kDegree;
    const Eigen::Vector3d error =
        sigma * Eigen::Vector3d(random->normal(), random->normal(), random->normal());
    input.up.emplace();
    input.up->sigma = sigma;
    input.up->up_base =
        expSo3(error) * (frame.truth->linear().transpose() * Eigen::Vector3d::UnitZ());
  }
  return input;
}

/// Rank of the true pose in a list of places, best first, from 1; 0: it is not in the list.
int rankOf(const Pose& truth, const std::vector<PoseCluster>& clusters) {
  for (size_t i = 0; i < clusters.size(); ++i)
    if (isNear(clusters[i].pose, truth, kRightPose)) return static_cast<int>(i) + 1;
  return 0;
}

/// The pose that the localizer gets at the first image: the true pose with a random error.
PoseGaussian startOf(const Pose& truth, TrialKind kind, const TrialOptions& o,
                     RandomSource* random) {
  PoseGaussian start;
  const bool offset = kind == TrialKind::kOffset;
  const double metres = offset ? o.offset : 0.1, radians = offset ? o.angle * kDegree : 0.05;
  Twist error;
  error.head<3>() = metres * random->uniform() * random->direction();
  error.tail<3>() = radians * random->uniform() * random->direction();
  start.mean = normalized(truth * expSe3(error));
  start.covariance.diagonal().head<3>().setConstant(metres * metres / 4);
  start.covariance.diagonal().tail<3>().setConstant(radians * radians / 4);
  return start;
}

/// Whether the images show so few lines of the model at the true pose that they do not fix the
/// pose.
bool isBare(const LocalizationMap& map, const LiveResult& result, const Pose& truth) {
  if (!map.usesImages()) return false;
  double lines = 0;
  for (const auto& image : result.images)
    lines += map.evaluate({{image, Pose::Identity(), 1, nullptr}}, {truth}).front().line_count;
  return lines < kFewLines;
}

Outcome fly(const std::shared_ptr<const LocalizationMap>& map, TrialKind kind,
            const TrialOptions& o, uint64_t seed) {
  Outcome outcome;
  outcome.seed = seed;
  TrialFlight flight(o.scenario, kind, seed, o.rate, static_cast<size_t>(o.images),
                     static_cast<size_t>(o.event), o.blackout, o.drift);
  RandomSource random(seed * 17 + 3);
  LiveLocalizer localizer(map);
  const bool has_event = hasEvent(kind);
  const int event = has_event ? o.event + darkImages(o, kind) : 0;
  RecordedFrame frame;
  bool announced = !has_event;
  for (int i = 0; flight.next(&frame); ++i) {
    if (i == 0) {
      if (kind == TrialKind::kGlobal)
        localizer.searchEverywhere();
      else
        localizer.setPose(startOf(*frame.truth, kind, o, &random));
    }
    const LiveResult r = localizer.process(inputOf(frame, flight, o, &random));
    outcome.search_ms += r.search_ms;
    const Twist error = logSe3(r.estimate.mean.inverse() * *frame.truth);
    const bool right =
        error.head<3>().norm() < kRightPose.position && error.tail<3>().norm() < kRightPose.angle;
    if (i >= event) {
      ++outcome.looked;
      outcome.bare += isBare(*map, r, *frame.truth) ? 1 : 0;
    }
    const bool tracking = r.state == LocalizerState::kTracking;
    outcome.tracking += tracking ? 1 : 0;
    outcome.silent += tracking && !right ? 1 : 0;
    if (tracking) outcome.nees.push_back(squaredMahalanobis(error, r.estimate.covariance));
    if (has_event && i >= o.event && !tracking && !announced) {
      announced = true;
      outcome.announced_after = i - o.event;
    }
    // Until the localizer has noticed the event, `tracking` is about the old pose. This counts as a
    // silent failure and not as a pose that was found.
    const bool found = tracking && (right || announced || !has_event);
    if (i >= event && found && outcome.found_after < 0) {
      outcome.found_after = i - event + 1;
      outcome.wrong = !right;
    }
    outcome.right_at_end = right && localizer.isInitialized();
    outcome.rank = rankOf(*frame.truth, r.clusters);
  }
  return outcome;
}

nlohmann::json jsonOf(const Outcome& o, double rate) {
  return {{"seed", o.seed},
          {"found_after_images", o.found_after},
          {"found_after_s", o.found_after < 0 ? -1 : o.found_after / rate},
          {"wrong", o.wrong},
          {"tracking", o.tracking},
          {"silent_failures", o.silent},
          {"announced_after_s", o.announced_after < 0 ? -1 : o.announced_after / rate},
          {"right_at_end", o.right_at_end},
          {"rank_in_search_at_end", o.rank},
          {"images_with_few_lines", o.bare},
          {"search_ms", o.search_ms}};
}

nlohmann::json summaryOf(const std::vector<Outcome>& outcomes, const TrialOptions& o) {
  int found = 0, wrong = 0, saw_little = 0, tracking = 0, silent = 0, silent_flights = 0,
      right_at_end = 0;
  std::vector<double> after, announced, nees, search;
  for (const Outcome& t : outcomes) {
    found += t.isFound() ? 1 : 0;
    saw_little += !t.isFound() && !t.wrong && t.sawLittle() ? 1 : 0;
    wrong += t.wrong ? 1 : 0;
    tracking += t.tracking;
    silent += t.silent;
    silent_flights += t.silent > 0 ? 1 : 0;
    right_at_end += t.right_at_end ? 1 : 0;
    if (t.isFound()) after.push_back(t.found_after);
    if (t.announced_after >= 0) announced.push_back(t.announced_after / o.rate);
    if (t.search_ms > 0) search.push_back(t.search_ms / 1000);
    nees.insert(nees.end(), t.nees.begin(), t.nees.end());
  }
  const auto mean = [](const std::vector<double>& v) {
    double sum = 0;
    for (double x : v) sum += x;
    return v.empty() ? 0 : sum / static_cast<double>(v.size());
  };
  return {{"scenario", o.scenario},
          {"kind", o.kind},
          {"flights", outcomes.size()},
          {"found", found},
          {"wrong", wrong},
          {"not_found", static_cast<int>(outcomes.size()) - found - wrong},
          {"not_found_saw_little", saw_little},
          {"right_at_end", right_at_end},
          {"found_after_images_median", summarize(after).median},
          {"found_after_images_p90", summarize(after).p90},
          {"announced_after_s_median", summarize(announced).median},
          {"images_tracking", tracking},
          {"silent_failure_images", silent},
          {"silent_failure_flights", silent_flights},
          {"search_s_mean", mean(search)},
          {"nees_mean", mean(nees)}};
}

int run(TrialOptions o) {
  checkOutput(o.out);
  const TrialKind kind = trialKind(o.kind);
  if (o.images == 0) {
    o.images = kind == TrialKind::kGlobal ? 20 : kind == TrialKind::kOffset ? 10 : 80;
    if (kind == TrialKind::kKidnap) o.images = o.event + static_cast<int>(std::lround(5 * o.rate));
    if (kind == TrialKind::kBlackout)
      o.images = o.event + static_cast<int>(std::lround((o.blackout + 5) * o.rate));
  }
  const int over = hasEvent(kind) ? o.event + darkImages(o, kind) : 0;
  if (hasEvent(kind) && o.images <= over)
    throw ParameterError("--images " + std::to_string(o.images) + ": must be more than " +
                         std::to_string(over) + ", else the flight ends before the event " +
                         "is over (--event, --blackout, --rate)");
  Parameters params = o.parameters.load();
  if (o.depth) params.likelihood.cues = Cues::kBoth;
  const auto map = makeMap(Scenario::fromYamlFile(o.scenario).model_file, params);
  std::vector<Outcome> outcomes;
  nlohmann::json flights = nlohmann::json::array();
  ProgressBar bar(o.kind, static_cast<size_t>(o.count));
  for (int k = 0; k < o.count; ++k) {
    outcomes.push_back(fly(map, kind, o, o.first_seed + static_cast<uint64_t>(k)));
    flights.push_back(jsonOf(outcomes.back(), o.rate));
    if (!o.out.empty())
      writeJson(o.out, {{"summary", summaryOf(outcomes, o)}, {"flights", flights}});
    bar.advance();
  }
  const nlohmann::json summary = summaryOf(outcomes, o);
  if (o.json) {
    std::printf("%s\n", textOf(summary).c_str());
    return kExitOk;
  }
  std::printf(
      "%s, %s: %d flights, %d found, %d wrong, %d not found (%d of these with fewer than %.0f "
      "lines in view in most images); images until found: median %.0f, ",
      o.scenario.c_str(), o.kind.c_str(), o.count, summary["found"].get<int>(),
      summary["wrong"].get<int>(), summary["not_found"].get<int>(),
      summary["not_found_saw_little"].get<int>(), kFewLines,
      summary["found_after_images_median"].get<double>());
  std::printf("90 %% %.0f\n", summary["found_after_images_p90"].get<double>());
  std::printf("  %d images tracking, %d of these at a wrong pose, in %d flights; mean NEES %.2f\n",
              summary["images_tracking"].get<int>(), summary["silent_failure_images"].get<int>(),
              summary["silent_failure_flights"].get<int>(), summary["nees_mean"].get<double>());
  return kExitOk;
}

}  // namespace

void addTrials(CLI::App* app, Action* action) {
  auto o = std::make_shared<TrialOptions>();
  CLI::App* c = app->add_subcommand(
      "trials",
      "fly random flights with a fault through a building, and count how often the localizer "
      "reports the fault and finds the pose again");
  c->add_option("scenario", o->scenario, "YAML file as for simulate; its path is not used")
      ->required();
  c->add_option("--kind", o->kind,
                "fault of the flights: global (default; the start is not known), offset (the start "
                "has an error), kidnap (the robot is carried elsewhere), blackout (there is no "
                "light and odometry drifts), track (no fault)");
  c->add_option("--count", o->count, "number of flights; default 50")->check(CLI::PositiveNumber);
  c->add_option(
       "--images", o->images,
       "number of images of a flight; 0 (default): 20 for global, 10 for offset, 80 for track, "
       "until 5 s after the event for kidnap and blackout")
      ->check(CLI::NonNegativeNumber);
  c->add_option("--rate", o->rate, "images per second; default 10")->check(numberFrom(0.01, 1000));
  c->add_option("--event", o->event,
                "number of the image at which the fault begins (kidnap, blackout); default 30")
      ->check(CLI::PositiveNumber);
  c->add_option("--first-seed", o->first_seed,
                "seed of the first flight; each later flight has the next seed; default 1");
  c->add_option("--offset", o->offset, "largest position error of the start, m (offset); default 1")
      ->check(numberFrom(0, 1000));
  c->add_option("--angle", o->angle,
                "largest rotation error of the start, degrees (offset); default 15")
      ->check(numberFrom(0, 180));
  c->add_option("--blackout", o->blackout, "duration of the darkness, s (blackout); default 10")
      ->check(numberFrom(0, 1000));
  c->add_option("--drift", o->drift,
                "distance that odometry drifts in the darkness, m (blackout); default 1")
      ->check(numberFrom(0, 1000));
  c->add_flag("--no-gravity", o->no_gravity,
              "do not give roll and pitch to the localizer; default: they are given (--imu-sigma)");
  c->add_option("--imu-sigma", o->imu_sigma_deg,
                "standard deviation of the given roll and pitch, degrees; default 1")
      ->check(numberFrom(0, 90));
  c->add_flag("--no-mask", o->no_mask,
              "do not give masks of the movable objects; default: exact masks are given");
  c->add_flag("--depth", o->depth,
              "use a depth camera as well (likelihood.cues = both); its images have no noise and "
              "are not darkened by a blackout");
  c->add_option(
      "--out", o->out,
      "JSON file with the result of every flight, written after each flight; default: none");
  c->add_flag("--json", o->json, "print the summary as JSON; default: as text");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
