// How LiveLocalizer starts the search and takes its results.
#include "edge_mcl/localization/search/background_search.h"
#include "edge_mcl/localization/search/global_localizer.h"
#include "edge_mcl/localization/search/pose_tolerances.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

PoseGaussian LiveLocalizer::searchGuess() const {
  // Without odometry a lost pose has slipped from one wrong place to the next, and its covariance
  // tells nothing of it. So its roll and pitch are not used, and it is searched for farther away.
  constexpr PoseTolerance kSlipped{1, 15 * kDegree};
  PoseGaussian guess = filter_.estimate();
  if (is_blind_) addVariance(kSlipped, &guess);
  return guess;
}

void LiveLocalizer::makeFinder() {
  const uint64_t seed = map_->params().filter.seed * 7919 + 17;
  if (!finder_ && search_in_background_)
    finder_ = std::make_unique<BackgroundSearch>(*map_, seed);
  else if (!finder_)
    finder_ = std::make_unique<GlobalLocalizer>(*map_, seed);
}

void LiveLocalizer::prepareSearch() {
  if (search_in_background_) makeFinder();
}

void LiveLocalizer::beginSearch(bool only_around) {
  makeFinder();
  // When there is a pose, even a lost one, the search tries poses around it as well.
  if (initial_)
    finder_->begin(only_around ? filter_.estimate() : searchGuess(), only_around);
  else
    finder_->begin();
  searching_ = true;
  only_around_ = only_around;
}

void LiveLocalizer::forgetPose() {
  initial_.reset();
  given_.reset();
  states_.forgetPose();
  odometry_of_update_.reset();
}

void LiveLocalizer::searchEverywhere() {
  forgetPose();
  beginSearch(false);
}

void LiveLocalizer::searchAround(const PoseGaussian& guess) {
  forgetPose();
  makeFinder();
  finder_->begin(guess, true);
  searching_ = only_around_ = true;
}

void LiveLocalizer::search(const LiveInput& input, const std::vector<CameraView>& views,
                           LiveResult* result) {
  const SearchReport report = finder_->process(views, input.up);
  result->clusters = report.clusters;
  result->next_view = report.next_view;
  result->search_keyframes = report.keyframes;
  result->search_ms = report.total_ms;
  result->updated = true;
  // A pose that is not found around the guess so soon is somewhere else.
  constexpr int kAroundGuess = 8;  // keyframes
  if (only_around_ && !isInitialized() && !report.converged && report.keyframes >= kAroundGuess &&
      finder_->isPrepared())
    beginSearch(false);
  if (!report.keyframe || !(report.converged || agreesWith(report))) return;
  const bool repeats = isRepeated(report);
  filter_.initialize(report.estimate);
  if (report.velocity) filter_.setVelocity(*report.velocity);
  begin();
  probability_.begin(!report.stale);
  if (report.stale) proof_.require(false);
  fresh_ = false;  // the pose belongs to this moment
  states_.excuse(input.time);
  result->relocalized = true;
  // The search has just explained these images. The filter uses them for its own covariance.
  useImages(views, result);
  // Without odometry only the search itself ties the pose to earlier images. Few lines fit in many
  // places, such as the other side of a cupboard. But a proof must not begin anew for ever.
  constexpr double kFewLines = 8;
  const double lines = result->report.visible_lines;
  if (is_blind_ && lines > 0 && lines < kFewLines && !repeats) proof_.require(true);
  if (addToProof(input.time, result)) judge(input.time, true, true);
}

bool LiveLocalizer::isRepeated(const SearchReport& report) const {
  constexpr int kImages = 3;
  return isInitialized() && proof_.confirmations() >= kImages &&
         isNear(report.estimate.mean, filter_.estimate().mean, kSamePose);
}

bool LiveLocalizer::agreesWith(const SearchReport& report) const {
  // Search and filter begin at different poses and reach their results in different ways. It is not
  // to be expected that both end at the same wrong pose, which explains several keyframes as no
  // other hypothesis does.
  constexpr int kKeyframes = 3;
  return report.convincing && report.keyframes >= kKeyframes && isRepeated(report);
}

}  // namespace edge_mcl
