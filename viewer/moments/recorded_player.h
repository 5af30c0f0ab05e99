/// A recording with a timeline: play, pause, back and forth, on to where it was lost.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "edge_mcl/viewer/moments/moment_store.h"
#include "edge_mcl/viewer/moments/recorded_view.h"
#include "edge_mcl/viewer/moments/view_source.h"

namespace edge_mcl {

/// Localizes in a thread of its own, a moment ahead of what is shown. What was localized once is
/// shown again from memory.
class RecordedPlayer : public ViewSource {
 public:
  /// @param loop begin again at the end.
  RecordedPlayer(std::unique_ptr<RecordedView> view, bool loop, size_t most_bytes = 512U << 20);
  ~RecordedPlayer() override;

  bool poll(ViewMoment* moment, HistoryView* history, double strip_seconds) override;
  void setPose(const PoseGaussian& pose) override;
  std::optional<Timeline> timeline() const override;
  void play(bool playing) override;
  void setSpeed(double speed) override;
  void seek(size_t position) override;
  void findLost() override;

 private:
  void work();
  bool isLostFirst(size_t i) const;  // and was not before
  void show(size_t position);
  void playOn();

  const size_t total_;
  const bool loop_;
  std::unique_ptr<RecordedView> view_;  // of the worker

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  MomentStore store_;
  ViewHistory history_;
  std::optional<PoseGaussian> new_pose_;
  size_t position_ = 0, wanted_ = 1;  // localized so far at least
  bool finished_ = false, running_ = true, playing_ = true, fresh_ = false, hunting_ = false;
  size_t hunted_ = 0;  // moments looked at
  std::string problem_;
  double speed_ = 1;
  double shown_at_ = 0;  // wall clock, s
  std::thread worker_;
};

}  // namespace edge_mcl
