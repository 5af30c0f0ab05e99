#include "edge_mcl/localization/search/background_search.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/localization/search/global_localizer.h"
#include "edge_mcl/localization/search/pose_tolerances.h"

namespace edge_mcl {

namespace {

/// Whether odometry is too uncertain after a motion for the pose to be trusted. The limits
/// correspond to about three seconds of flight. After three seconds of darkness, too, one image
/// that fits is no proof of the pose.
bool isFarByOdometry(const Vector6& variance, double blind) {
  // Standard deviations in m and rad, and a time without odometry in s.
  constexpr double kPosition = 0.05, kAngle = 1.5 * kDegree, kBlind = 0.3;
  const Vector6 sigma = variance.cwiseMax(0).cwiseSqrt();
  return sigma.head<3>().maxCoeff() > kPosition || sigma.tail<3>().maxCoeff() > kAngle ||
         blind > kBlind;
}

/// Priorities of the search, where cores are short and the filter's images go first, and of the
/// preparation, which goes last.
constexpr int kSearchNice = 10;  // a tenth of the time of a thread with normal priority
constexpr int kPreparationNice = 19;

/// Share of the visible model that shows in the images. Wrong poses of the flights through office,
/// house and hall have 0.25 to 0.48, right ones 0.8 and more.
constexpr double kPlausible = 0.6;

/// Lowers the priority of this thread. Failure does no harm.
void yieldToOthers(int nice) {
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice);
}

}  // namespace

BackgroundSearch::BackgroundSearch(const LocalizationMap& map, uint64_t seed)
    : map_(map), seed_(seed), preparation_([this] { prepare(); }), thread_([this] { run(); }) {}

BackgroundSearch::~BackgroundSearch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
  preparation_.join();
}

void BackgroundSearch::begin() { beginWith({}); }

void BackgroundSearch::begin(const PoseGaussian& guess, bool only_there) {
  beginWith({guess, only_there});
}

void BackgroundSearch::beginWith(Begin begin) {
  since_begin_ = {};
  since_view_ = {};
  has_view_ = false;
  is_around_ = begin.only_there;
  const std::lock_guard<std::mutex> lock(mutex_);
  begin_ = std::move(begin);
  waiting_.clear();
  reported_.reset();
  is_news_ = false;
  failure_ = nullptr;
}

void BackgroundSearch::move(const BaseMotion& motion) {
  since_begin_.add(motion);
  since_view_.add(motion);
}

void BackgroundSearch::dropOne() {
  // Odometry bridges any gap, so the oldest image goes. Without it the gaps must stay small.
  size_t dropped = 0;
  if (since_view_.blind > 0) {
    double smallest = INFINITY;
    for (size_t i = 0; i + 1 < waiting_.size(); ++i) {
      const double gap = waiting_[i].before.elapsed + waiting_[i + 1].before.elapsed;
      if (gap < smallest) dropped = i;
      smallest = std::min(smallest, gap);
    }
  }
  BaseMotion both = waiting_[dropped].before;
  both.add(waiting_[dropped + 1].before);
  waiting_[dropped + 1].before = both;
  waiting_.erase(waiting_.begin() + static_cast<long>(dropped));
}

void BackgroundSearch::skipToNewest() {
  while (waiting_.size() > 1) {
    BaseMotion both = waiting_[0].before;
    both.add(waiting_[1].before);
    waiting_[1].before = both;
    waiting_.pop_front();
  }
}

void BackgroundSearch::offer(const std::vector<CameraView>& views,
                             const std::optional<UpReading>& up) {
  const SearchParameters& p = map_.params().search;
  if (has_view_ && !since_view_.isKeyframe(p, is_around_) && !since_view_.isGlance(p)) return;
  // When the queue is full, one image is dropped. Those that remain are closer together than if
  // only the newest one waited. Without odometry the images alone tell the motion, so the images of
  // one search, about a second, may wait.
  constexpr size_t kMostWaiting = 3, kMostGlances = 12;
  if (waiting_.size() >= (since_view_.blind > 0 ? kMostGlances : kMostWaiting)) {
    dropOne();
  }
  waiting_.push_back({since_view_, views, up, since_begin_});
  since_view_ = {};
  has_view_ = true;
}

SearchReport BackgroundSearch::process(const std::vector<CameraView>& views,
                                       const std::optional<UpReading>& up) {
  SearchReport report;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    offer(views, up);
    if (reported_) report = carriedToNow(*reported_);
    report.keyframe = std::exchange(is_news_, false);
  }
  wake_.notify_one();
  if (!report.keyframe) report.total_ms = 0;
  return report;
}

SearchReport BackgroundSearch::carriedToNow(const Report& then) const {
  Pose motion = then.since_begin.step.inverse() * since_begin_.step;
  // Without odometry, motion goes on as it was. After a longer time it may be anything.
  constexpr double kSteady = 0.5;  // s
  const double blind = since_begin_.blind - then.since_begin.blind;
  if (then.report.velocity && blind > 0)
    motion = motion * expSe3(*then.report.velocity * std::min(blind, kSteady));
  const Vector6 variance = since_begin_.variance - then.since_begin.variance;
  SearchReport now = then.report;
  const Vector6 sigma = variance.cwiseMax(0).cwiseSqrt();
  now.stale = then.over_gap || isFarByOdometry(variance, blind);
  now.estimate = moved(now.estimate, motion, sigma);
  for (PoseCluster& cluster : now.clusters) cluster.pose = normalized(cluster.pose * motion);
  return now;
}

void BackgroundSearch::prepare() {
  struct Stopped {};
  yieldToOthers(kPreparationNice);
  tbb::task_arena alone(1);
  try {
    alone.execute([&] {
      map_.preparedPlaces([this](double) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (stop_) throw Stopped();
      });
    });
  } catch (const Stopped&) {
  } catch (const std::exception&) {
    // The first search meets the same fault and reports it.
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_prepared_ = true;
  }
  wake_.notify_one();
}

bool BackgroundSearch::isPrepared() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return is_prepared_;
}

bool BackgroundSearch::canSearch() const {
  if (waiting_.empty()) return false;
  // Around a guess a search finds the pose without prepared places as well.
  return is_prepared_ || (begin_ ? begin_->only_there : only_there_);
}

void BackgroundSearch::run() {
  yieldToOthers(kSearchNice);
  std::optional<GlobalLocalizer> search;  // made in this thread, because that takes a while
  const int cores = tbb::info::default_concurrency();
  // Somebody waits for a search around a guess. When it is not short, tracking goes first again.
  constexpr int kShort = 8;  // keyframes
  tbb::task_arena whole(cores), half(std::max(1, cores / 2));
  int keyframes = 0;  // of this search
  bool over_gap = false;
  // Without odometry nothing carries a result to the present but the images that wait. So a pose
  // that was found is followed through them before it is told.
  bool catches_up = false, has_news = false, is_plausible = true;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stop_ || canSearch(); });
    if (stop_) return;
    const std::optional<Begin> begin = std::exchange(begin_, std::nullopt);
    if (begin) only_there_ = begin->only_there;
    if (begin) {
      is_plausible = true;
      keyframes = 0;
    }
    // Hypotheses that explain little are hardly the right ones. They are not worth the time to
    // follow them through the images that wait.
    if (!is_plausible && waiting_.back().before.blind <= 0) skipToNewest();
    const bool uses_lookup = is_prepared_;
    tbb::task_arena& arena = only_there_ && keyframes < kShort ? whole : half;
    const View view = std::move(waiting_.front());
    waiting_.pop_front();
    const bool is_newest = waiting_.empty(), is_blind = view.before.blind > 0;
    if (begin) catches_up = has_news = false;
    const bool is_look = is_newest && !catches_up;
    // A pose that was followed by images alone may have slipped to a neighbour that looks alike.
    const bool is_gap =
        isFarByOdometry(view.before.variance, view.before.blind) || (is_blind && !is_look);
    // Without prepared places there are fewer hypotheses, so a wrong one may have no rival.
    over_gap = (!begin && (over_gap || is_gap)) || !uses_lookup;
    lock.unlock();
    SearchReport report;
    std::exception_ptr failure;
    try {
      arena.execute([&] {
        if (!search) search.emplace(map_, seed_);
        search->useLookup(uses_lookup);
        if (begin && begin->guess)
          search->begin(*begin->guess, begin->only_there);
        else if (begin)
          search->begin();
        search->move(view.before);
        report = search->process(view.views, view.up, is_look);
      });
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (begin_) continue;  // begin() was called meanwhile, so this result is outdated
    failure_ = failure;
    keyframes = report.keyframes;
    if (report.keyframe) is_plausible = report.match_ratio >= kPlausible;
    if (failure || !(report.keyframe || is_blind)) continue;
    has_news = has_news || report.keyframe;
    catches_up = is_blind && report.converged && !waiting_.empty();
    reported_ = {std::move(report), view.since_begin, over_gap};
    if (catches_up || !has_news) continue;
    is_news_ = true;
    has_news = false;
  }
}

}  // namespace edge_mcl
