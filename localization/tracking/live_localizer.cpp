#include "edge_mcl/localization/tracking/live_localizer.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/search/image_contours.h"
#include "edge_mcl/localization/search/pose_tolerances.h"

namespace edge_mcl {

namespace {

/// After a longer time without a trusted pose or without images, one image that fits is not enough:
/// odometry may have drifted (0.1 m/s is not rare) to where an image fits one shelf aside.
constexpr double kBlindly = 3;  // s

/// Standard deviations of a look-alike, which the refinement has just found.
constexpr PoseTolerance kJump{0.05, 1 * kDegree};

/// Share of the depth on the model from which a surface counts as a proof of the pose. Of wrong
/// poses with fewer than six lines one in twenty reaches it, or more
/// (docs/decisions/tracking-probability.md).
constexpr double kOnSurface = 0.97;

}  // namespace

LiveLocalizer::LiveLocalizer(std::shared_ptr<const LocalizationMap> map, bool search_in_background)
    : map_(std::move(map)),
      tracking_(map_->params().tracking),
      filter_(map_->params().filter, map_->params().refinement),
      proof_(map_->params()),
      odometry_(map_->params().filter),
      search_in_background_(search_in_background) {}

void LiveLocalizer::begin() {
  initial_ = filter_.estimate();
  states_.givePose();
  fresh_ = true;
  odometry_.interrupt();
  odometry_of_update_.reset();
  searching_ = false;
  mask_lifter_.forget();
  depth_masker_.forget();
  surface_agreement_.forget();
  probability_.begin(false);
  look_alikes_.begin();
  proof_.begin(isSpreadWide());
  if (proof_.isNeeded()) beginSearch(true);
}

bool LiveLocalizer::isSpreadWide() const { return isWiderThan(kWideSpread, filter_.estimate()); }

bool LiveLocalizer::isLeftToSearch(const LiveInput& input) const {
  // Particles that are spread so wide see the model from many places. Weighing them takes as long
  // as a search in the whole building and seldom finds the pose. Without odometry they are weighed
  // all the same, because they are the only other hope.
  return state() == LocalizerState::kLost && searching_ && !only_around_ && input.odometry &&
         isSpreadWide();
}

void LiveLocalizer::setPose(const PoseGaussian& pose) {
  filter_.initialize(pose);
  objects_.forget();  // their places may belong to another pose
  begin();
  given_ = initial_;
}

void LiveLocalizer::setMap(std::shared_ptr<const LocalizationMap> map) {
  finder_.reset();        // it refers to the old map
  mask_lifter_.forget();  // it knows the lines by number
  depth_masker_.forget();
  surface_agreement_.forget();
  objects_.forget();
  calibration_checks_.forget();
  filter_.setFocalError(0);
  tracked_.reset();
  map_ = std::move(map);
  if (searching_) beginSearch(false);
}

bool LiveLocalizer::addToProof(double time, LiveResult* result) {
  const std::optional<double> agreement = surface_agreement_.value();
  auto odds = result->updated ? oddsOf(result->report, agreement) : std::nullopt;
  if (odds) {
    const LookAlikeWatch::Result& alike = result->look_alike;
    if (alike.log_odds) odds = amongLookAlikes(*odds, *alike.log_odds, alike.by_motion);
    result->log_odds = odds->log_odds;
    probability_.add(time, *odds);
  } else {
    probability_.wait(time);
  }
  // When only depth was used, the match ratio counts as 1.
  const double ratio = result->report.used_samples > 0 ? result->match_ratio : 1;
  const bool contradicts = result->updated && (!result->report.has_information ||
                                               probability_.value() < tracking_.keep_probability);
  const bool on_surface = agreement && *agreement >= kOnSurface;
  return proof_.add(
      {time, contradicts, isConfirmed(*result), ratio, result->report.visible_lines, on_surface},
      filter_.estimate());
}

void LiveLocalizer::setParticles(std::vector<Pose> poses, std::vector<double> log_weights) {
  filter_.setParticles(std::move(poses), std::move(log_weights));
  objects_.forget();  // their places may belong to another pose
  begin();
  given_ = initial_;
}

bool LiveLocalizer::isUnusable(StampGuard::Verdict verdict, LiveResult* result) {
  using Verdict = StampGuard::Verdict;
  if (verdict == Verdict::kLate) {
    result->problem = "the image is older than the one before and is not used";
  } else if (verdict == Verdict::kStandsStill) {
    result->problem = "the time stamps of the images stand still; the images are not used";
    // Time goes on, although the stamps do not.
    if (initial_) judge(*last_time_ + stamps_.stalled(), false, false);
  } else if (verdict == Verdict::kAhead) {
    result->problem =
        "the time stamp of the image is far ahead of the one before; the image is not used, unless "
        "the next one confirms the time";
  }
  result->late = !result->problem.empty();
  return result->late;
}

bool LiveLocalizer::advanceTo(const LiveInput& input, LiveResult* result) {
  const StampGuard::Verdict verdict = stamps_.judge(input.time, input.odometry.has_value());
  if (isUnusable(verdict, result)) return false;
  if (verdict == StampGuard::Verdict::kReturned && isInitialized()) {
    // The robot has gone on meanwhile, and the pose with it. But all times belong to the other
    // clock.
    filter_.initialize(PoseGaussian(filter_.estimate()));
    begin();
    proof_.require(false);
    result->restarted = true;
    result->problem = "the clock came back from a jump; the pose is kept and needs proof";
  } else if (verdict == StampGuard::Verdict::kJumpedBack ||
             verdict == StampGuard::Verdict::kReturned) {
    // A recording is played again, or a simulation begins again. Then the robot is at the given
    // pose. But the recording may have been set back only a little, so the given pose needs proof.
    // A pose that the search has found meanwhile is not used: it belongs to another time.
    if (given_) {
      setPose(PoseGaussian(*given_));
      proof_.require(true);
    } else {
      searchEverywhere();
    }
    result->restarted = true;
    result->problem = given_
                          ? "the clock jumped back; localization begins again at the initial pose"
                          : "the clock jumped back; the search begins again";
  }
  // A pose that was just given holds for the first moment after it and is not predicted.
  if (result->restarted) objects_.forget();  // their times are those of the other clock
  if (last_time_ && !result->restarted) {
    const double dt = input.time - *last_time_;
    // In a long time without images anything may have happened. But a camera may also be slow, or
    // send its images in bursts, so the time is compared with earlier ones.
    const bool is_gap = longest_interval_ > 0 && dt > kBlindly && dt > 3 * longest_interval_;
    longest_interval_ = std::max(dt, 0.9 * longest_interval_);
    if (is_gap && initial_ && !fresh_) {
      proof_.interrupt(!odometry_.incrementTo(input.odometry));
      // The pose needs proof, but no image has contradicted it. So the time until `lost` starts
      // now.
      if (states_.trusted()) states_.excuse(input.time);
    }
    if (!fresh_) follow(input, dt);
  }
  fresh_ = false;
  last_time_ = input.time;
  odometry_.read(input.odometry);
  if (initial_ && input.up && !filter_.correctTilt(*input.up))
    result->problem = "roll and pitch of the IMU contradict the pose and are not used";
  return true;
}

PoseGaussian LiveLocalizer::presentPose() const {
  if (!odometry_.isWaiting()) return filter_.estimate();
  const OdometryStep step = odometry_.waited();
  return moved(filter_.estimate(), step.pose, step.sigma);
}

void LiveLocalizer::predict(const OdometryStep& step) {
  is_blind_ = false;
  if (searching_) finder_->move({step.pose, step.sigma.cwiseAbs2(), step.time, 0});
  if (!initial_) return;
  filter_.setOdometryNoiseFactor(step.noise_factor);
  filter_.predictWithOdometry(step.pose, step.time);
  proof_.move(step.pose, step.sigma);
}

void LiveLocalizer::predictBlindly(double dt) {
  odometry_.interrupt();
  is_blind_ = true;
  const FilterParameters& p = map_->params().filter;
  if (searching_) finder_->move(BaseMotion::of(p, std::nullopt, dt));
  if (!initial_) return;
  const Pose before = filter_.estimate().mean;
  const Vector6 drift = filter_.velocitySigma() * std::min(dt, tracking_.max_gap);
  // After so long the clock has jumped, or the robot may be anywhere. It is looked for where it
  // was.
  constexpr double kPause = 10, kNear = 0.3;  // s
  if (dt > kPause) {
    filter_.forgetVelocity();
    filter_.predictWithoutOdometry(kNear);
  } else {
    filter_.predictWithoutOdometry(std::min(dt, tracking_.max_gap), dt);
  }
  proof_.moveByVelocity(before.inverse() * filter_.estimate().mean, walkNoise(p, dt), drift);
}

void LiveLocalizer::follow(const LiveInput& input, double dt) {
  const std::optional<Pose> increment = odometry_.incrementTo(input.odometry);
  if (increment) odometry_.wait(*increment, dt);
  if (increment && isInitialized() && !searching_ && !hasMoved(input)) return;
  if (odometry_.isWaiting()) {
    predict(odometry_.waited());
    odometry_.endWaiting();
  }
  if (!increment) predictBlindly(dt);
}

bool LiveLocalizer::hasMoved(const LiveInput& input) const {
  const TrackingParameters& p = tracking_;
  if (p.update_min_d <= 0 && p.update_min_a_deg <= 0) return true;
  if (!states_.trusted() || proof_.isNeeded())
    return true;  // a pose in doubt needs images for its proof, at rest too
  if (input.force_update || !input.odometry || !odometry_of_update_) return true;
  const PoseTolerance narrow{tracking_.converged_std_position,
                             tracking_.converged_std_angle_deg * kDegree};
  if (isWiderThan({narrow.position / 2, narrow.angle / 2}, presentPose())) return true;
  const Pose motion = odometry_of_update_->inverse() * *input.odometry;
  const double angle_deg = logSo3(motion.linear()).norm() * 180 / M_PI;
  return (p.update_min_d > 0 && motion.translation().norm() >= p.update_min_d) ||
         (p.update_min_a_deg > 0 && angle_deg >= p.update_min_a_deg);
}

std::string LiveLocalizer::useImages(std::vector<CameraView> views, LiveResult* result) {
  std::string problem;
  const auto hasImage = [](const CameraView& v) { return v.image != nullptr; };
  // Not checked while converging: some particles may see more of the model than their mean does.
  if (std::any_of(views.begin(), views.end(), hasImage) && state() != LocalizerState::kConverging &&
      map_->evaluate(views, {filter_.estimate().mean}).front().sample_weight <
          tracking_.min_visible_samples) {
    problem = "too little of the model in view at the expected pose";
    views.erase(std::remove_if(views.begin(), views.end(), hasImage), views.end());
    if (views.empty()) return problem;
  }
  const Matrix6 predicted = filter_.estimate().covariance;
  result->report = filter_.update(*map_, views);
  result->updated = true;
  const UpdateReport& r = result->report;
  if (!r.has_information) return "nothing of the model in view";
  result->match_ratio =
      r.used_samples > 0 ? static_cast<double>(r.matched_samples) / r.used_samples : 0;
  // An image that does not confirm the pose needs no second opinion, and a lost pose is the
  // search's.
  const auto odds = oddsOf(r);
  if (searching_ || !odds || odds->log_odds <= 0) return problem;
  result->look_alike =
      look_alikes_.look(*map_, views, filter_.estimate().mean, predicted, *last_time_);
  return problem;
}

bool LiveLocalizer::isConfirmed(const LiveResult& result) const {
  const TrackingParameters& p = tracking_;
  const UpdateReport& r = result.report;
  if (!result.updated || !r.has_information) return false;
  const double needed =
      states_.trusted() ? std::min(p.keep_probability, p.min_probability) : p.min_probability;
  if (probability_.value() < needed) return false;
  const bool enough_evidence = map_->params().likelihood.model == LikelihoodModel::kPaper ||
                               r.evidence_per_line >= p.min_evidence;
  const bool by_edges = result.match_ratio >= p.min_match_ratio && enough_evidence;
  const bool by_depth = r.depth_agreement >= p.min_depth_agreement;
  // All data that were used must agree with the pose.
  const bool used_edges = r.visible_lines > 0, used_depth = r.depth_points > 0;
  return (used_edges || used_depth) && (by_edges || !used_edges) && (by_depth || !used_depth);
}

void LiveLocalizer::jumpTo(const Pose& pose, LiveResult* result) {
  PoseGaussian start;
  start.mean = pose;
  start.covariance.diagonal().head<3>().setConstant(kJump.position * kJump.position);
  start.covariance.diagonal().tail<3>().setConstant(kJump.angle * kJump.angle);
  filter_.initialize(start);
  begin();
  objects_.forget();  // their places belong to the other pose
  proof_.require(false);
  fresh_ = false;  // the pose belongs to this moment
  result->relocalized = true;
  result->problem =
      "a pose that looks like the tracked one fits better; localization goes on there";
}

void LiveLocalizer::judge(double time, bool trusted, bool used) {
  const PoseTolerance most{tracking_.converged_std_position,
                           tracking_.converged_std_angle_deg * kDegree};
  const bool narrow = !isWiderThan(most, filter_.estimate());
  const bool doubtful = !used || probability_.value() < tracking_.lost_probability;
  states_.judge({time, used, trusted, narrow, doubtful}, tracking_.lost_after);
}

std::optional<PoseGaussian> LiveLocalizer::trackedPose(double age) const {
  if (!tracked_ || !last_time_ || std::abs(*last_time_ - tracked_at_) > age) return std::nullopt;
  return tracked_;
}

LiveResult LiveLocalizer::process(const LiveInput& input) {
  LiveResult result;
  if (!isInitialized() && !searching_) {
    result.problem = "no initial pose yet";
    stamps_.judge(input.time, true);
    last_time_ = input.time;
    odometry_.forgetReading();
    odometry_.read(input.odometry);
    return result;
  }
  const Pose before = filter_.estimate().mean;
  const double step_time = last_time_ ? input.time - *last_time_ : 0;
  try {
    if (advanceTo(input, &result)) processImages(input, &result);
  } catch (const Error& e) {
    result.problem = e.what();
  }
  if (!input.odometry && (result.relocalized || result.restarted))
    odometry_.forgetReading();  // the estimate has jumped
  else if (!input.odometry && !result.late)
    odometry_.carry(before.inverse() * filter_.estimate().mean, step_time, tracking_.max_gap);
  result.state = state();
  result.estimate = presentPose();
  if (isInitialized()) result.probability = probability_.value();
  result.objects = objects_.objects(result.late && last_time_ ? *last_time_ : input.time);
  if (result.state == LocalizerState::kTracking && !result.late) {
    tracked_ = result.estimate;
    tracked_at_ = input.time;
  }
  result.odometry = odometry_.calibration();
  return result;
}

void LiveLocalizer::processImages(const LiveInput& input, LiveResult* result) {
  if (odometry_.isWaiting()) {
    states_.excuse(input.time);
    return;
  }
  std::string problem;
  const std::vector<CameraView> views = prepare(input, result, &problem);
  bool trusted = false;
  if (isInitialized()) {
    if (!views.empty() && !isLeftToSearch(input)) {
      const std::string of_use = useImages(views, result);
      if (!of_use.empty()) problem = of_use;
    }
    if (result->updated) odometry_of_update_ = input.odometry;
    trusted = addToProof(input.time, result);
    const bool confirmed = isConfirmed(*result);
    const bool unlikely = probability_.value() < tracking_.keep_probability;
    if (result->updated && !confirmed && unlikely && problem.empty())
      problem = "the image does not confirm the pose";
    judge(input.time, trusted, result->updated);
    if (result->updated)
      odometry_.update(result->report, trusted && state() == LocalizerState::kTracking);
    if (result->look_alike.better) return jumpTo(*result->look_alike.better, result);
    learnUnderMasks(input, result->updated);
    followObjects(input, result);
    if (problem.empty()) checkCalibration(input, result);
    if (trusted) searching_ = false;
    if (state() == LocalizerState::kLost) {
      const bool contradicted =
          result->updated
              ? !confirmed
              : !searching_ && std::any_of(views.begin(), views.end(), [](const CameraView& view) {
                  return view.image && showsLongContours(view.image->edges);
                });
      const bool astray = isSpreadWide() || states_.timeWithoutTrust(input.time) > kBlindly;
      // With odometry the robot cannot be anywhere, because odometry has followed it.
      if (contradicted || astray) proof_.require(contradicted && !input.odometry);
      const bool has_cause = contradicted || isSpreadWide() || result->updated;
      if (proof_.isNeeded() && has_cause && (!searching_ || only_around_) &&
          map_->params().search.recover)
        beginSearch(false);
    }
  }
  if (searching_ && !views.empty()) {
    search(input, views, result);
    if (problem.empty() && !result->relocalized) problem = "searching for the pose";
  }
  if (!problem.empty()) result->problem = problem;
}

}  // namespace edge_mcl
