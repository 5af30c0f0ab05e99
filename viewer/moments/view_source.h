/// Where the window's moments come from.
#pragma once

#include <optional>

#include "edge_mcl/viewer/moments/view_history.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Of a recording; live there is none.
struct Timeline {
  size_t position = 0;   ///< moment that is shown
  size_t available = 0;  ///< moments that have been localized
  size_t total = 0;
  bool playing = false;
};

/// All methods are called by the window's thread.
class ViewSource {
 public:
  virtual ~ViewSource() = default;

  /// What to show now. @return false when it has not changed since the last call.
  virtual bool poll(ViewMoment* moment, HistoryView* history, double strip_seconds) = 0;
  /// The robot is here (T_map_base); the localizer begins anew there.
  virtual void setPose(const PoseGaussian& pose) = 0;

  virtual std::optional<Timeline> timeline() const { return std::nullopt; }
  virtual void play(bool) {}
  virtual void setSpeed(double) {}
  virtual void seek(size_t) {}
  /// Forwards to where the robot is lost next, or to the end.
  virtual void findLost() {}
};

}  // namespace edge_mcl
