#include "edge_mcl/localization/search/global_localizer.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/search/jump_cost.h"

namespace edge_mcl {

namespace {

/// Roll and pitch with a larger standard deviation are not used, because a search without them
/// finds them just as well.
constexpr double kUselessTilt = 10 * kDegree;

/// Roll and pitch of a lost pose. A robot that is carried or flies seldom tilts much, so they are
/// assumed to hold. @return none when their standard deviation is too large
std::optional<UpReading> tiltOf(const PoseGaussian& lost) {
  constexpr double kAtLeast = 5 * kDegree;
  UpReading up;
  up.up_base = lost.mean.linear().transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d rotation = lost.covariance.bottomRightCorner<3, 3>();
  const double about_up = up.up_base.dot(rotation * up.up_base);
  up.sigma = std::max(kAtLeast, std::sqrt(std::max(0.0, rotation.trace() - about_up) / 2));
  if (!(up.sigma <= kUselessTilt)) return std::nullopt;
  return up;
}

}  // namespace

GlobalLocalizer::GlobalLocalizer(const LocalizationMap& map, uint64_t seed)
    : map_(map), search_(map), other_sides_(map), random_(seed) {}

void GlobalLocalizer::begin() {
  keyframes_.clear();
  keyframe_count_ = look_count_ = 0;
  hypotheses_.clear();
  guess_.reset();
  only_guess_ = false;
  up_.reset();
  tilt_is_assumed_ = false;
  since_ = since_look_ = {};
  report_ = {};
}

void GlobalLocalizer::begin(const PoseGaussian& guess, bool only_there) {
  begin();
  guess_ = guess;
  only_guess_ = only_there;
  up_ = tiltOf(guess);
  tilt_is_assumed_ = true;
}

void GlobalLocalizer::move(const BaseMotion& motion) {
  since_.add(motion);
  since_look_.add(motion);
  const Vector6 sigma = motion.variance.cwiseSqrt();
  if (up_) {
    up_->up_base = motion.step.linear().transpose() * up_->up_base;
    up_->sigma = std::hypot(up_->sigma, sigma[3]);
    if (up_->sigma > kUselessTilt) up_.reset();
  }
  if (guess_) guess_ = moved(*guess_, motion.step, sigma);
}

PoseGaussian GlobalLocalizer::predicted(const FoundPose& before, const Pose& motion,
                                        const Vector6& variance) {
  PoseGaussian result = moved({before.pose, before.covariance}, motion, variance.cwiseSqrt());
  addVariance(kFollowFloor, &result);
  return result;
}

SearchReport GlobalLocalizer::process(const std::vector<CameraView>& views,
                                      const std::optional<UpReading>& up, bool look) {
  const auto begin = std::chrono::steady_clock::now();
  // When the assumed roll and pitch have not led to a pose for so long, they are dropped.
  constexpr int kAssumedFor = 6;  // keyframes
  if (tilt_is_assumed_ && keyframe_count_ >= kAssumedFor) up_.reset();
  if (up) {
    up_ = up;
    tilt_is_assumed_ = false;
  }
  const SearchParameters& p = map_.params().search;
  const bool is_glance = since_look_.isGlance(p) && !hypotheses_.empty();
  // A user who has given a pose waits for it, and the robot may stand still.
  const bool is_due = since_.isKeyframe(p, only_guess_);
  if (!keyframes_.empty() && !is_glance && !is_due) return reportBetween();
  SearchViews seen = search_.prepare(views);
  follow(seen);
  if (!keyframes_.empty() && !is_due && !haveMoved()) return reportBetween();
  append(std::move(seen));
  if (look) this->look();
  sort();
  if (look) smooth();
  prune();
  report_ = judge();
  report_.keyframe = true;
  if (look) addNextView(&report_);
  report_.total_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  return report_;
}

FoundPose GlobalLocalizer::followed(const SearchViews& seen, const PoseGaussian& expected) const {
  FoundPose found = search_.follow(seen, expected);
  found.log_likelihood -= jumpCost(expected, found.pose);
  return found;
}

void GlobalLocalizer::follow(const SearchViews& seen) {
  tbb::parallel_for(size_t{0}, hypotheses_.size(), [&](size_t i) {
    Hypothesis& h = hypotheses_[i];
    h.expected = predicted(h.newest, since_look_.step, since_look_.variance);
    h.newest = followed(seen, h.expected);
    h.pose = h.newest.pose;
  });
  since_look_ = {};
}

bool GlobalLocalizer::haveMoved() const {
  // The best hypothesis alone may be a wrong one that jumps about.
  constexpr size_t kMost = 9;
  const size_t count = std::min(kMost, hypotheses_.size());
  size_t moved = 0;
  for (size_t i = 0; i < count; ++i) {
    const Hypothesis& h = hypotheses_[i];
    BaseMotion motion;
    motion.step = h.history.back().pose.inverse() * h.pose;
    if (motion.isKeyframe(map_.params().search)) ++moved;
  }
  return 2 * moved > count;
}

void GlobalLocalizer::append(SearchViews seen) {
  keyframes_.push_back({std::move(seen), since_});
  ++keyframe_count_;
  since_ = {};
  for (Hypothesis& h : hypotheses_) {
    h.total += h.newest.log_likelihood;
    h.history.push_back(h.newest);
    ++h.followed;
  }
  if (keyframes_.size() <= static_cast<size_t>(map_.params().search.window)) return;
  keyframes_.pop_front();
  for (Hypothesis& h : hypotheses_) {
    h.total -= h.history.front().log_likelihood;
    h.history.pop_front();
  }
}

const SearchReport& GlobalLocalizer::reportBetween() {
  report_.keyframe = false;
  report_.total_ms = 0;
  if (hypotheses_.empty()) {
    report_.estimate.mean = Pose::Identity();
  } else {
    report_.estimate.mean = normalized(hypotheses_.front().pose * since_look_.step);
  }
  return report_;
}

std::vector<CameraView> GlobalLocalizer::rig() const {
  // The images of the last few keyframes count as images of one robot with several cameras.
  // Odometry is accurate over so few keyframes, and a wrong pose seldom explains all of these
  // images.
  constexpr size_t kMost = 3;
  std::vector<CameraView> views;
  Pose to_then = Pose::Identity();
  for (size_t k = keyframes_.size(); k-- > 0 && keyframes_.size() - k <= kMost;) {
    for (CameraView view : keyframes_[k].seen.views) {
      view.T_base_camera = to_then * view.T_base_camera;
      views.push_back(std::move(view));
    }
    to_then = to_then * keyframes_[k].since.step.inverse();
  }
  return views;
}

std::vector<Pose> GlobalLocalizer::candidates() {
  std::vector<Pose> found;
  const std::vector<CameraView> views = rig();
  if (guess_) found = search_.around(views, *guess_, up_, &random_);
  const auto add = [&](const std::vector<Pose>& more) {
    found.insert(found.end(), more.begin(), more.end());
  };
  add(alongWhatWasOpen());
  if (only_guess_) {
    add(search_.lookedUp(views, up_, SearchRegion::around(*guess_)));
    return found;
  }
  add(whereItLooksAlike());
  const std::vector<Pose> looked_up = search_.lookedUp(views, up_);
  add(looked_up);
  const int turn = turnOfEverywhere(!looked_up.empty());
  if (turn == 0) return found;
  // The search with all orientations and the search with the orientations of the hypotheses take
  // turns. The second search is of both kinds.
  const bool even = turn % 2 == 0;
  if (!even || turn == 2) add(search_.everywhere(views, up_, &random_));
  if (even && !hypotheses_.empty()) add(search_.everywhere(views, up_, rotations(), &random_));
  return found;
}

int GlobalLocalizer::turnOfEverywhere(bool is_looked_up) const {
  // When so many searches have not found the pose, the next one hardly does. So later searches are
  // rare.
  constexpr int kEager = 12, kSeldom = 4;
  // Prepared places find most poses in a tenth of the time. The search that needs no lines along
  // the axes of the building then comes after some of those, unless a pose explains everything.
  constexpr int kAfterLookups = 4;
  if (is_looked_up && report_.convincing) return 0;
  const int every = (look_count_ > kEager ? kSeldom : 1) * (is_looked_up ? kAfterLookups : 1);
  return look_count_ % every == 0 ? look_count_ / every : 0;
}

std::vector<Pose> GlobalLocalizer::alongWhatWasOpen() const {
  // When all lines in view run in one direction, a pose may slide along them. The next image with
  // more lines fixes it. But a hypothesis that is followed finds only the nearest place that looks
  // alike (shelves, steps). So poses along the open direction are tried as well.
  constexpr size_t kMost = 4;                   // hypotheses
  constexpr double kOpen = 0.12, kStep = 0.12;  // m
  constexpr double kFarthest = 1.5;             // standard deviations
  constexpr double kWidest = 2;                 // m; farther away other searches find the pose
  std::vector<Pose> found;
  for (size_t i = 0; i < std::min(kMost, hypotheses_.size()); ++i) {
    const Hypothesis& h = hypotheses_[i];
    if (h.followed == 0) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
        h.expected.covariance.topLeftCorner<3, 3>());
    const double sigma = std::min(kWidest, std::sqrt(std::max(0.0, axes.eigenvalues()[2])));
    if (sigma < kOpen) continue;
    for (double offset = kStep; offset <= kFarthest * sigma; offset += kStep)
      for (const double sign : {-1.0, 1.0}) {
        Pose pose = h.expected.mean;
        pose.translation() += pose.linear() * (sign * offset * axes.eigenvectors().col(2));
        found.push_back(pose);
      }
  }
  return found;
}

std::vector<Pose> GlobalLocalizer::whereItLooksAlike() {
  // A wrong pose that explains several images is often one bay or one floor away from the right
  // one.
  constexpr size_t kMost = 4;  // hypotheses
  std::vector<Pose> found, tried;
  for (size_t i = 0; i < hypotheses_.size() && tried.size() < kMost; ++i) {
    Hypothesis& h = hypotheses_[i];
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Pose& pose) { return isNear(pose, h.pose, kSamePlace); }))
      continue;
    tried.push_back(h.pose);
    if (h.repeated || h.followed == 0) continue;
    h.repeated = true;
    const std::vector<Pose> alike = search_.alike(keyframes_.back().seen, h.pose);
    found.insert(found.end(), alike.begin(), alike.end());
    const std::vector<Pose> turned = other_sides_.of(h.pose);
    found.insert(found.end(), turned.begin(), turned.end());
  }
  return found;
}

std::vector<Eigen::Matrix3d> GlobalLocalizer::rotations() const {
  constexpr size_t kMost = 8;
  constexpr double kApart = 4 * kDegree;
  std::vector<Pose> chosen;
  for (const Hypothesis& h : hypotheses_)
    for (int quarter = 0; quarter < 4 && chosen.size() < kMost; ++quarter) {
      Pose turned = Pose::Identity();
      turned.linear() =
          Eigen::AngleAxisd(quarter * M_PI / 2, Eigen::Vector3d::UnitZ()) * h.pose.linear();
      if (std::none_of(chosen.begin(), chosen.end(),
                       [&](const Pose& c) { return rotationAngle(c, turned) < kApart; }))
        chosen.push_back(turned);
    }
  std::vector<Eigen::Matrix3d> result;
  result.reserve(chosen.size());
  for (const Pose& pose : chosen) result.push_back(pose.linear());
  return result;
}

GlobalLocalizer::Hypothesis GlobalLocalizer::backwards(const FoundPose& found) const {
  Hypothesis h;
  h.pose = found.pose;
  h.newest = found;
  h.history = {found};
  h.total = found.log_likelihood;
  FoundPose last = found;
  for (size_t k = keyframes_.size() - 1; k > 0; --k) {
    const Keyframe& later = keyframes_[k];
    last = followed(keyframes_[k - 1].seen,
                    predicted(last, later.since.step.inverse(), later.since.variance));
    h.total += last.log_likelihood;
    h.history.push_front(last);
  }
  return h;
}

void GlobalLocalizer::look() {
  ++look_count_;
  const std::vector<Pose> starts = candidates();
  std::vector<FoundPose> found(starts.size());
  tbb::parallel_for(size_t{0}, starts.size(), [&](size_t i) {
    found[i] =
        search_.sharpen(keyframes_.back().seen, starts[i], search_.looseAround(starts[i], up_));
  });
  std::stable_sort(found.begin(), found.end(), [](const FoundPose& a, const FoundPose& b) {
    return a.log_likelihood > b.log_likelihood;
  });
  std::vector<FoundPose> fresh;
  for (const FoundPose& f : found) {
    if (fresh.size() >= static_cast<size_t>(map_.params().search.hypotheses)) break;
    const auto known = [&](const auto& other) { return isNear(other.pose, f.pose, kSamePose); };
    if (std::none_of(hypotheses_.begin(), hypotheses_.end(), known) &&
        std::none_of(fresh.begin(), fresh.end(), known) &&
        search_.admits(keyframes_.back().seen.views, f.pose))
      fresh.push_back(f);
  }
  const size_t old = hypotheses_.size();
  hypotheses_.resize(old + fresh.size());
  tbb::parallel_for(size_t{0}, fresh.size(),
                    [&](size_t i) { hypotheses_[old + i] = backwards(fresh[i]); });
}

void GlobalLocalizer::sort() {
  std::stable_sort(hypotheses_.begin(), hypotheses_.end(),
                   [](const Hypothesis& a, const Hypothesis& b) { return a.total > b.total; });
}

void GlobalLocalizer::smooth() {
  // A hypothesis that was found beside the true pose carries the low scores of its first keyframes,
  // even when later images have moved it to the true pose. So the earlier keyframes are judged
  // again from its newest pose.
  constexpr size_t kMost = 8;
  const size_t count = std::min(kMost, hypotheses_.size());
  tbb::parallel_for(size_t{0}, count, [&](size_t i) {
    Hypothesis& h = hypotheses_[i];
    if (h.followed == 0) return;  // it was followed backwards just now
    FoundPose newest = h.history.back();
    newest.log_likelihood += jumpCost(h.expected, newest.pose);  // backwards() charges this step
    Hypothesis smoothed = backwards(newest);
    if (smoothed.total <= h.total) return;
    h.total = smoothed.total;
    h.history = std::move(smoothed.history);
  });
  sort();
}

void GlobalLocalizer::prune() {
  const SearchParameters& p = map_.params().search;
  const std::vector<CameraView>& views = keyframes_.back().seen.views;
  std::vector<Hypothesis> kept;
  for (Hypothesis& h : hypotheses_) {
    if (kept.size() >= static_cast<size_t>(p.hypotheses)) break;
    if (!search_.admits(views, h.pose)) continue;
    if (!kept.empty() && h.total < kept.front().total - 4 * p.min_margin - 200) break;
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Hypothesis& k) {
      return isNear(k.pose, h.pose, kMergedHypothesis);
    });
    if (same == kept.end())
      kept.push_back(std::move(h));
    else
      same->followed = std::max(same->followed, h.followed);
  }
  hypotheses_ = std::move(kept);
}

}  // namespace edge_mcl
