/// A search of the pose in a thread of its own, so that images are used while it thinks.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "edge_mcl/localization/search/pose_finder.h"

namespace edge_mcl {

/// GlobalLocalizer takes seconds for a new view, in which a robot flies metres: views that are far
/// apart share little, and odometry drifts between them. Here views wait in a queue while an older
/// one is worked at; those that are not the newest are only followed, not searched anew. What is
/// found is carried to the present by odometry; a pose that odometry has carried far, now or
/// between two views, is reported as stale. Takes half of the cores at most. What it finds depends
/// on how fast the machine is.
class BackgroundSearch : public PoseFinder {
 public:
  /// The map must outlive this object.
  BackgroundSearch(const LocalizationMap& map, uint64_t seed);
  /// Waits for the view that is worked at.
  ~BackgroundSearch() override;

  void begin() override;
  void begin(const PoseGaussian& guess, bool only_there) override;
  void move(const BaseMotion& motion) override;
  /// Returns at once. @throws what the search has thrown meanwhile
  SearchReport process(const std::vector<CameraView>& views,
                       const std::optional<UpReading>& up) override;

 private:
  struct Begin {
    std::optional<PoseGaussian> guess;
    bool only_there = false;
  };
  struct View {
    BaseMotion before;  // since the view before
    std::vector<CameraView> views;
    std::optional<UpReading> up;
    BaseMotion since_begin;
  };
  struct Report {
    SearchReport report;
    BaseMotion since_begin;  // of its view
    // Between two of its views odometry may have drifted farther than following them sets right.
    bool over_gap = false;
  };

  void beginWith(Begin begin);
  void offer(const std::vector<CameraView>& views, const std::optional<UpReading>& up);
  SearchReport carriedToNow(const Report& then) const;
  void run();

  const LocalizationMap& map_;
  const uint64_t seed_;
  // Used by the caller's thread only.
  BaseMotion since_begin_, since_view_;  // the newest view that was offered
  bool has_view_ = false;                // since it began
  // Shared.
  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Begin> begin_;  // asked for, not yet done
  std::deque<View> waiting_;
  std::optional<Report> reported_;  // newest
  bool is_news_ = false;            // nobody has been told yet
  std::exception_ptr failure_;
  bool stop_ = false;
  std::thread thread_;  // last, uses all of the above
};

}  // namespace edge_mcl
