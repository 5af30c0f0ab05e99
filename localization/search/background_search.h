/// Runs the global search in a thread of its own, so that images are still used during the search.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "edge_mcl/localization/search/pose_finder.h"

namespace edge_mcl {

class GlobalLocalizer;

/// A PoseFinder that runs a GlobalLocalizer in a thread of its own.
///
/// GlobalLocalizer takes seconds for a keyframe. A robot flies metres in this time. Keyframes far
/// apart show few common lines, and odometry drifts between them. So keyframes wait in a queue
/// while the search works. Hypotheses are only followed through keyframes that are not the newest;
/// new hypotheses are searched for in the newest one. Odometry carries the result to the present. A
/// pose is reported as stale when odometry has carried it too far, since the result or between two
/// keyframes. The search uses at most half of the cores, and all for the first keyframes around a
/// guess. Its result depends on the speed of the machine.
class BackgroundSearch : public PoseFinder {
 public:
  /// Starts the threads of the search and of the preparation. A search of the whole map waits until
  /// its places are prepared. @param map must outlive this object. @param seed of the random
  /// generator.
  BackgroundSearch(const LocalizationMap& map, uint64_t seed);
  /// Ends the threads after the keyframe and the places that they are working on.
  ~BackgroundSearch() override;

  void begin() override;
  void begin(const PoseGaussian& guess, bool only_there) override;
  void move(const BaseMotion& motion) override;
  /// Queues the images if they make a keyframe, and returns the newest result at once.
  /// @throws the exception of the search thread, if there was one since the last call.
  SearchReport process(const std::vector<CameraView>& views,
                       const std::optional<UpReading>& up) override;
  bool isPrepared() override;

 private:
  struct Begin {
    std::optional<PoseGaussian> guess;
    bool only_there = false;
  };
  /// A keyframe that waits for the search.
  struct View {
    BaseMotion before;  // motion since the keyframe queued before
    std::vector<CameraView> views;
    std::optional<UpReading> up;
    BaseMotion since_begin;  // motion since begin()
  };
  struct Report {
    SearchReport report;
    BaseMotion since_begin;  // motion from begin() to the keyframe of the report
    // True: between two keyframes odometry may have drifted farther than following corrects.
    bool over_gap = false;
  };

  void beginWith(Begin begin);
  /// Drops an image that waits.
  void dropOne();
  /// Drops all images that wait but the newest.
  void skipToNewest();
  /// Puts the images into the queue if they make a keyframe.
  void offer(const std::vector<CameraView>& views, const std::optional<UpReading>& up);
  /// The report with its poses carried to the present by odometry.
  SearchReport carriedToNow(const Report& then) const;
  void run();
  /// Prepares the places of the map, unless the thread has to end.
  void prepare();
  /// Whether the search can use images that wait. Needs mutex_.
  bool canSearch() const;

  const LocalizationMap& map_;
  const uint64_t seed_;
  // Used by the caller's thread only.
  BaseMotion since_begin_, since_view_;  // motion since begin(), since the newest queued keyframe
  bool has_view_ = false;                // a keyframe was queued since begin()
  bool is_around_ = false;               // the search is one around its guess
  // Shared by both threads, under mutex_.
  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Begin> begin_;  // requested, not yet done by the thread
  std::deque<View> waiting_;
  std::optional<Report> reported_;  // newest result
  bool is_news_ = false;            // process() has not returned it yet
  std::exception_ptr failure_;
  bool stop_ = false, is_prepared_ = false;
  bool only_there_ = false;           // the search that runs is one around its guess
  std::thread preparation_, thread_;  // the last members, because they use all members above
};

}  // namespace edge_mcl
