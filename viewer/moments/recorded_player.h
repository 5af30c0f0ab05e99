/// Plays a recording with a timeline: play, pause, seek, and a jump to where the robot is lost.
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

/// Localizes in a thread of its own, one moment ahead of the moment that is shown. Moments that
/// were localized once are shown again from memory.
class RecordedPlayer : public ViewSource {
 public:
  /// @param loop true: playing begins again after the last moment. @param most_bytes memory for
  /// stored moments, see MomentStore.
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
  bool isLostFirst(size_t i) const;  // lost in moment i, but not in the one before
  void show(size_t position);
  void playOn();

  const size_t total_;
  const bool loop_;
  std::unique_ptr<RecordedView> view_;  // used by the worker only

  mutable std::mutex mutex_;  // guards all members below
  std::condition_variable changed_;
  MomentStore store_;
  ViewHistory history_;
  std::optional<PoseGaussian> new_pose_;
  size_t position_ = 0, wanted_ = 1;  // moment shown; number of moments to localize
  bool finished_ = false, running_ = true, playing_ = true, fresh_ = false, hunting_ = false;
  size_t hunted_ = 0;  // next moment that findLost() checks
  std::string problem_;
  double speed_ = 1;
  double shown_at_ = 0;  // wall clock, s
  std::thread worker_;
};

}  // namespace edge_mcl
