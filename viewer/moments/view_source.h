/// Defines the interface through which the window gets its moments.
#pragma once

#include <optional>

#include "edge_mcl/viewer/moments/view_history.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Timeline of a recording. Live data have none.
struct Timeline {
  size_t position = 0;   ///< number of the moment that is shown
  size_t available = 0;  ///< number of moments that are localized
  size_t total = 0;      ///< number of all moments
  bool playing = false;
};

/// Source of moments. The window calls all methods from its own thread.
class ViewSource {
 public:
  virtual ~ViewSource() = default;

  /// Gives the moment to show now. @return false when it has not changed since the last call.
  virtual bool poll(ViewMoment* moment, HistoryView* history, double strip_seconds) = 0;
  /// Restarts the localizer at a pose (T_map_base) that the user gave.
  virtual void setPose(const PoseGaussian& pose) = 0;

  virtual std::optional<Timeline> timeline() const { return std::nullopt; }
  /// Starts or pauses.
  virtual void play(bool) {}
  /// Sets the speed as a multiple of the recording's own.
  virtual void setSpeed(double) {}
  /// Shows the moment with this number.
  virtual void seek(size_t) {}
  /// Goes to the next moment in which the robot becomes lost, or to the end.
  virtual void findLost() {}
};

}  // namespace edge_mcl
