/// Converts times of a device's own clock to times of this computer.
#pragma once

#include <algorithm>
#include <optional>

#include "edge_mcl/core/base/clock_step.h"

namespace edge_mcl {

/// Converts times of a device's clock to times of this computer.
///
/// A frame arrives some time after it was taken, and the delay varies. The smallest delay is the
/// best measure of the offset between the clocks. That offset may grow slowly, as clocks drift.
class DeviceClock {
 public:
  /// @param device_time time of a frame on the device's clock, s
  /// @param arrival time at which the frame arrived here, s
  /// @return time at which the frame was taken, plus the smallest delay, s on the clock of arrival
  double toHost(double device_time, double arrival) {
    constexpr double kDrift = 1e-4;  // s/s, more than a quartz clock drifts
    const double offset = arrival - device_time;
    const bool restarted = clockStep(last_, device_time) == ClockStep::kJumpedBack;
    // A frame that seems to take this much longer than the others comes from a restarted device.
    if (!offset_ || restarted || offset - *offset_ > kClockJump) {
      offset_ = offset;
      last_ = device_time;
    } else {
      // Frames of several streams may arrive in another order than they were taken.
      const double since = std::max(0.0, device_time - last_);
      *offset_ = std::min(*offset_ + kDrift * since, offset);
      last_ = std::max(last_, device_time);
    }
    return device_time + *offset_;
  }

 private:
  std::optional<double> offset_;
  double last_ = 0;
};

}  // namespace edge_mcl
