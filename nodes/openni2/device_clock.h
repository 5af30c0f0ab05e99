/// Times of a device's own clock as times of this machine.
#pragma once

#include <algorithm>
#include <optional>

namespace edge_mcl {

/// A frame arrives some time after it was taken, and the delay varies; the least delay seen is the
/// best measure of the clocks' offset. It may grow slowly, as clocks drift.
class DeviceClock {
 public:
  /// @param device_time seconds of the device's clock, of one frame. @param arrival seconds here.
  /// @return when the frame was taken, seconds here, but for the least delay.
  double toHost(double device_time, double arrival) {
    constexpr double kDrift = 1e-4;  // s/s, more than quartz has
    constexpr double kJump = 1;      // s; the device began anew
    const double offset = arrival - device_time;
    if (!offset_ || device_time < last_ - kJump || offset - *offset_ > kJump) {
      offset_ = offset;
      last_ = device_time;
    } else {
      // Frames of several streams need not come in their order.
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
