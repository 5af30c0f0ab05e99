/// Decides which poses an autopilot gets.
#pragma once

#include <cstdint>
#include <optional>

#include "edge_mcl/core/base/parameter_range.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// When poses are passed on.
struct VisionGateParameters {
  double min_probability = 0.9;
  double settle = 0.3;
  double hold = 0.25;
  double jump = 0.3;
  double jump_angle_deg = 5;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("min_probability", min_probability, "", from(0, 1),
      "poses are passed on while the localizer tracks with at least this probability");
    v("settle", settle, "s", notNegative(),
      "time for which it must have tracked so before the first pose is passed on");
    v("hold", hold, "s", notNegative(),
      "time after the newest such image for which poses by odometry are passed on");
    v("jump", jump, "m", positive(),
      "a step of the pose against its steady motion counts as a relocalization");
    v("jump_angle_deg", jump_angle_deg, "deg", positive(),
      "a turn of the pose against its steady motion counts as a relocalization");
  }
};

/// Passes poses on only while the localizer is sure, and counts relocalizations. An estimator that
/// is told of a reset takes the new pose at once, and does not fight against it.
class VisionGate {
 public:
  explicit VisionGate(const VisionGateParameters& params) : params_(params) {}

  /// Takes the result for an image. @param time stamp of the image, s. @param pose T_map_base.
  void update(double time, bool is_tracking, double probability, const Pose& pose);
  /// Whether a pose of this time (s) may be passed on.
  bool isOpen(double time) const;
  /// Number of relocalizations, and of times when the gate opened anew; wraps at 256 as MAVLink's
  /// counter does.
  uint8_t resets() const { return resets_; }

 private:
  struct Last {
    double time;
    Pose pose;
    Twist velocity;  // in the frame of the base, per s
  };
  bool hasJumped(const Last& last, double time, const Pose& pose) const;

  VisionGateParameters params_;
  std::optional<double> sure_since_;  // s; none: the newest image was not sure
  std::optional<Last> last_;          // newest sure image
  bool was_open_ = false;
  uint8_t resets_ = 0;
};

}  // namespace edge_mcl
