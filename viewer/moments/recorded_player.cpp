#include "edge_mcl/viewer/moments/recorded_player.h"

#include <algorithm>
#include <chrono>

namespace edge_mcl {

namespace {
double wallClock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
}  // namespace

RecordedPlayer::RecordedPlayer(std::unique_ptr<RecordedView> view, bool loop, size_t most_bytes)
    : total_(view->imageCount()),
      loop_(loop),
      view_(std::move(view)),
      store_(most_bytes),
      worker_([this] { work(); }) {}

RecordedPlayer::~RecordedPlayer() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    running_ = false;
  }
  changed_.notify_all();
  worker_.join();
}

void RecordedPlayer::work() {
  for (;;) {
    std::optional<PoseGaussian> new_pose;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait(
          lock, [&] { return !running_ || (!finished_ && (hunting_ || store_.size() < wanted_)); });
      if (!running_) return;
      new_pose.swap(new_pose_);
    }
    ViewMoment moment;
    bool more = false;
    std::string problem;
    try {
      if (new_pose) view_->setPose(*new_pose);
      more = view_->next(&moment);
    } catch (const std::exception& e) {
      problem = e.what();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (more) {
      store_.add(moment);
      history_.add(moment);
      if (store_.size() == 1) show(0);
    } else {
      finished_ = true;
      problem_ = problem;
      fresh_ = fresh_ || !problem.empty();
    }
  }
}

bool RecordedPlayer::isLostFirst(size_t i) const {
  const auto lost = [&](size_t k) { return store_.stateOf(k) == LocalizerState::kLost; };
  return lost(i) && (i == 0 || !lost(i - 1));
}

void RecordedPlayer::show(size_t position) {
  position_ = position;
  wanted_ = std::max(wanted_, position + 2);
  fresh_ = true;
  shown_at_ = wallClock();
  changed_.notify_all();
}

void RecordedPlayer::playOn() {
  const double now = wallClock();
  while (position_ + 1 < store_.size()) {
    const double step = store_.timeOf(position_ + 1) - store_.timeOf(position_);
    const double due = shown_at_ + std::clamp(step, 0.0, 1.0) / speed_;
    if (now < due) return;
    // Moments that are overdue are skipped. When the player is more than 0.5 s behind, it continues
    // from now instead of catching up.
    const bool behind = now - due > 0.5;
    show(position_ + 1);
    shown_at_ = behind ? now : due;
  }
  if (finished_ && position_ + 1 >= store_.size() && store_.size() > 1) {
    if (loop_ && now - shown_at_ > 0.2)
      show(0);
    else if (!loop_)
      playing_ = false;
  }
}

bool RecordedPlayer::poll(ViewMoment* moment, HistoryView* history, double strip_seconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (hunting_) {
    for (; hunted_ < store_.size() && hunting_; ++hunted_)
      if (isLostFirst(hunted_)) {
        hunting_ = false;
        show(hunted_);
      }
    if (hunting_ && finished_) {
      hunting_ = false;
      if (store_.size() > 0) show(store_.size() - 1);
    }
  } else if (playing_ && store_.size() > 0) {
    playOn();
  }
  if (!fresh_ || store_.size() == 0) return false;
  fresh_ = false;
  *moment = store_.get(position_);
  if (!problem_.empty()) moment->problem = problem_;
  // The history drops its oldest moments, the store keeps all.
  const size_t forgotten = store_.size() - history_.size();
  *history = history_.view(position_ + 1 - std::min(position_ + 1, forgotten), strip_seconds);
  return true;
}

void RecordedPlayer::setPose(const PoseGaussian& pose) {
  const std::lock_guard<std::mutex> lock(mutex_);
  new_pose_ = pose;
  if (store_.size() > 0) show(store_.size() - 1);
}

std::optional<Timeline> RecordedPlayer::timeline() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return Timeline{position_, store_.size(), finished_ ? store_.size() : total_, playing_};
}

void RecordedPlayer::play(bool playing) {
  const std::lock_guard<std::mutex> lock(mutex_);
  playing_ = playing;
  hunting_ = false;
  shown_at_ = wallClock();
  if (playing && finished_ && position_ + 1 >= store_.size() && store_.size() > 0) show(0);
}

void RecordedPlayer::setSpeed(double speed) {
  const std::lock_guard<std::mutex> lock(mutex_);
  speed_ = std::clamp(speed, 0.01, 100.0);
}

void RecordedPlayer::seek(size_t position) {
  const std::lock_guard<std::mutex> lock(mutex_);
  hunting_ = false;
  if (store_.size() > 0) show(std::min(position, store_.size() - 1));
}

void RecordedPlayer::findLost() {
  const std::lock_guard<std::mutex> lock(mutex_);
  playing_ = false;
  hunting_ = true;
  hunted_ = position_ + 1;
  changed_.notify_all();
}

}  // namespace edge_mcl
