/// Something done every so often, by the wall clock.
#pragma once

#include <ros/time.h>

namespace edge_mcl {

/// For diagnostics: diagnostic_updater's own pace is that of ros::Time, and where that jumps back
/// (a bag in a loop) it falls silent until the old time comes again. Not thread-safe.
class WallPace {
 public:
  /// @param period s.
  bool isDue(double period) {
    const ros::WallTime now = ros::WallTime::now();
    if ((now - last_).toSec() < period) return false;
    last_ = now;
    return true;
  }

 private:
  ros::WallTime last_;
};

}  // namespace edge_mcl
