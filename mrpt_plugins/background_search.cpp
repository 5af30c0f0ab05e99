#include "edge_mcl/mrpt_plugins/background_search.h"

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "edge_mcl/mrpt_plugins/global_localizer.h"

namespace edge_mcl {

BackgroundSearch::BackgroundSearch(const LocalizationMap& map, uint64_t seed)
    : map_(map), seed_(seed), thread_([this] { run(); }) {}

BackgroundSearch::~BackgroundSearch() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void BackgroundSearch::begin() { beginWith({}); }

void BackgroundSearch::begin(const PoseGaussian& guess, bool only_there) {
  beginWith({guess, only_there});
}

void BackgroundSearch::beginWith(Begin begin) {
  moves_.clear();
  offered_.clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  begin_ = std::move(begin);
  waiting_.clear();
  reported_.reset();
  is_news_ = false;
}

void BackgroundSearch::move(const std::optional<Pose>& increment, double dt) {
  moves_.emplace_back(increment, dt);
  for (Offered& offered : offered_) offered.since.add(map_.params().filter, increment, dt);
}

void BackgroundSearch::offer(const std::vector<CameraView>& views,
                             const std::optional<UpReading>& up) {
  if (!offered_.empty() && !offered_.back().since.isNewView(map_.params().search)) return;
  // Older ones are given up; what remains is still less far apart than if all but one were.
  constexpr size_t kMostWaiting = 3;
  if (waiting_.size() >= kMostWaiting) {
    Moves& next = waiting_[1].moves;
    next.insert(next.begin(), waiting_[0].moves.begin(), waiting_[0].moves.end());
    waiting_.pop_front();
  }
  waiting_.push_back({std::move(moves_), views, up, ++count_});
  moves_.clear();
  offered_.push_back({count_, {}});
}

SearchReport BackgroundSearch::process(const std::vector<CameraView>& views,
                                       const std::optional<UpReading>& up) {
  SearchReport report;
  size_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    offer(views, up);
    if (reported_) {
      number = reported_->first;
      report = reported_->second;
    }
    report.keyframe = std::exchange(is_news_, false);
  }
  wake_.notify_one();
  if (!report.keyframe) report.total_ms = 0;
  if (number == 0) return report;
  while (offered_.front().number < number) offered_.pop_front();
  return carriedToNow(std::move(report), offered_.front().since);
}

SearchReport BackgroundSearch::carriedToNow(SearchReport report, const MotionSince& since) const {
  report.estimate = moved(report.estimate, since.motion, since.variance.cwiseSqrt());
  for (PoseCluster& cluster : report.clusters)
    cluster.pose = normalized(cluster.pose * since.motion);
  return report;
}

void BackgroundSearch::run() {
  std::optional<GlobalLocalizer> search;  // made here, as that takes a while
  tbb::task_arena arena(std::max(1, tbb::info::default_concurrency() / 2));
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return stop_ || !waiting_.empty(); });
    if (stop_) return;
    const std::optional<Begin> begin = std::exchange(begin_, std::nullopt);
    const View view = std::move(waiting_.front());
    waiting_.pop_front();
    const bool is_newest = waiting_.empty();
    lock.unlock();
    SearchReport report;
    std::exception_ptr failure;
    try {
      arena.execute([&] {
        if (!search) search.emplace(map_, seed_);
        if (begin && begin->guess)
          search->begin(*begin->guess, begin->only_there);
        else if (begin)
          search->begin();
        for (const auto& [increment, dt] : view.moves) search->move(increment, dt);
        report = search->process(view.views, view.up, is_newest);
      });
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (begin_) continue;  // nobody asks for this any more
    failure_ = failure;
    if (failure || !report.keyframe) continue;
    reported_ = {view.number, report};
    is_news_ = true;
  }
}

}  // namespace edge_mcl
