// edge-mcl trials: many random flights in which something goes wrong. Does it find itself, and does
// it know when it does not?
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/localization/backend_choice.h"
#include "edge_mcl/localization/search/pose_sharpener.h"
#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/trial_flight.h"

namespace edge_mcl {

namespace {

constexpr double kDegree = M_PI / 180;
// What counts as the right place.
constexpr double kRightPosition = 0.25, kRightAngle = 5 * kDegree;
// Fewer lines in view leave the pose open, also for who knows the truth.
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

/// Images from the event to where it is over.
int darkImages(const TrialOptions& o, TrialKind kind) {
  return kind == TrialKind::kBlackout ? static_cast<int>(std::lround(o.blackout * o.rate)) : 0;
}

/// How one flight went.
struct Outcome {
  uint64_t seed = 0;
  /// Images (from the event on) until it reports tracking; negative: never.
  int found_after = -1;
  bool wrong = false;        ///< found, but elsewhere
  int tracking = 0;          ///< images reported as tracking
  int silent = 0;            ///< of these, at a wrong pose
  int announced_after = -1;  ///< images after the event until it no longer says tracking
  bool right_at_end = false;
  int rank = 0;    ///< of the truth among what the search holds at the end, 1: best; 0: not there
  int looked = 0;  ///< images (from the event on)
  int bare = 0;    ///< of these, with fewer than kFewLines in view where it really is, or masked
  double search_ms = 0;
  std::vector<double> nees;  ///< of tracked images

  bool isFound() const { return found_after >= 0 && !wrong; }
  /// Most of what it saw was bare walls.
  bool sawLittle() const { return 2 * bare > looked; }
};

LiveInput inputOf(const RecordedFrame& frame, const TrialFlight& flight, const TrialOptions& o,
                  RandomSource* random) {
  LiveInput input;
  input.time = frame.time;
  input.odometry = frame.odometry;
  LiveInput::View view;
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
  input.views.push_back(std::move(view));
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

/// Place of the truth among hypotheses, best first, from 1; 0: not among them.
int rankOf(const Pose& truth, const std::vector<PoseCluster>& clusters) {
  for (size_t i = 0; i < clusters.size(); ++i)
    if (isNear(clusters[i].pose, truth, kRightPosition, kRightAngle))
      return static_cast<int>(i) + 1;
  return 0;
}

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

/// Whether an image shows too little of the model at the true pose to tell where that is.
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
        error.head<3>().norm() < kRightPosition && error.tail<3>().norm() < kRightAngle;
    if (i >= event) {
      ++outcome.looked;
      outcome.bare += isBare(*map, r, *frame.truth) ? 1 : 0;
    }
    const bool tracking = r.state == LocalizerState::kTracking;
    outcome.tracking += tracking ? 1 : 0;
    outcome.silent += tracking && !right ? 1 : 0;
    if (tracking) outcome.nees.push_back(error.dot(r.estimate.covariance.ldlt().solve(error)));
    if (has_event && i >= o.event && !tracking && !announced) {
      announced = true;
      outcome.announced_after = i - o.event;
    }
    // Until it has noticed, "tracking" is the old pose; that is a silent failure, not a find.
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
    throw ParameterError("--images " + std::to_string(o.images) + ": more than " +
                         std::to_string(over) + " needed, else the flight ends before the event " +
                         "is over (--event, --blackout, --rate)");
  Parameters params = o.parameters.load();
  if (o.depth) params.likelihood.cues = Cues::kBoth;
  const auto map =
      std::make_shared<LocalizationMap>(Scenario::fromYamlFile(o.scenario).model_file, params);
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
      "lines in view in most images); after %.0f images (median), ",
      o.scenario.c_str(), o.kind.c_str(), o.count, summary["found"].get<int>(),
      summary["wrong"].get<int>(), summary["not_found"].get<int>(),
      summary["not_found_saw_little"].get<int>(), kFewLines,
      summary["found_after_images_median"].get<double>());
  std::printf("%.0f (90 %%)\n", summary["found_after_images_p90"].get<double>());
  std::printf("  images tracking %d, of these at a wrong pose %d, in %d flights; NEES %.2f\n",
              summary["images_tracking"].get<int>(), summary["silent_failure_images"].get<int>(),
              summary["silent_failure_flights"].get<int>(), summary["nees_mean"].get<double>());
  return kExitOk;
}

}  // namespace

void addTrials(CLI::App* app, Action* action) {
  auto o = std::make_shared<TrialOptions>();
  CLI::App* c = app->add_subcommand(
      "trials",
      "random flights through a building in which something goes wrong: is it noticed, is "
      "the pose found again?");
  c->add_option("scenario", o->scenario, "YAML file as for simulate; its path is not used")
      ->required();
  c->add_option("--kind", o->kind,
                "global (start unknown), offset (start known badly), kidnap (carried elsewhere), "
                "blackout (no light, odometry drifts), track (nothing)");
  c->add_option("--count", o->count, "flights")->check(CLI::PositiveNumber);
  c->add_option("--images", o->images, "of a flight; 0: 20, 10, until 5 s after the event, 80")
      ->check(CLI::NonNegativeNumber);
  c->add_option("--rate", o->rate, "images per second")->check(CLI::PositiveNumber);
  c->add_option("--event", o->event, "image at which it goes wrong (kidnap, blackout)")
      ->check(CLI::PositiveNumber);
  c->add_option("--first-seed", o->first_seed, "of the flights");
  c->add_option("--offset", o->offset, "largest start error, m (offset)")
      ->check(CLI::NonNegativeNumber);
  c->add_option("--angle", o->angle, "largest start error, deg (offset)")
      ->check(CLI::NonNegativeNumber);
  c->add_option("--blackout", o->blackout, "s without light (blackout)")
      ->check(CLI::NonNegativeNumber);
  c->add_option("--drift", o->drift, "m that odometry drifts meanwhile (blackout)")
      ->check(CLI::NonNegativeNumber);
  c->add_flag("--no-gravity", o->no_gravity, "roll and pitch are not known");
  c->add_option("--imu-sigma", o->imu_sigma_deg, "error of roll and pitch, deg")
      ->check(CLI::NonNegativeNumber);
  c->add_flag("--no-mask", o->no_mask, "movable objects are not masked");
  c->add_flag("--depth", o->depth,
              "a depth camera as well (exact, and not darkened by a blackout); cues: both");
  c->add_option("--out", o->out, "JSON file with every flight, written as they end");
  c->add_flag("--json", o->json, "print the summary as JSON");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
