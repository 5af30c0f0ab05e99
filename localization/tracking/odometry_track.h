/// The motion of the base as odometry tells it, with its known errors taken away.
#pragma once

#include <optional>

#include "edge_mcl/localization/filter/odometry_calibration.h"
#include "edge_mcl/localization/filter/pose_filter.h"

namespace edge_mcl {

/// A motion with its uncertainty.
struct OdometryStep {
  Pose pose = Pose::Identity();     ///< in the axes of the base before it
  double time = 0;                  ///< s; rest does not count
  Vector6 sigma = Vector6::Zero();  ///< standard deviations per axis, m and rad
  double noise_factor = 1;          ///< contained in sigma
};

/// Holds the last reading, the motion since the last used image, and the learnt errors.
class OdometryTrack {
 public:
  explicit OdometryTrack(const FilterParameters& params) : params_(params) {}

  /// Motion from the last reading to this one; none: one of them is missing.
  std::optional<Pose> incrementTo(const std::optional<Pose>& reading) const;
  /// Remembers a reading, if there is one.
  void read(const std::optional<Pose>& reading);
  /// Forgets the last reading.
  void forgetReading() { last_reading_.reset(); }
  /// Carries the last reading on, where the next one is missing. The next reading contains the
  /// motion of the step whose reading is missing. The filter has moved by that step already, so its
  /// own motion stands for it.
  /// @param motion of the estimate in this step @param dt its duration, s
  /// @param longest time without a reading, after which it is forgotten, s
  void carry(const Pose& motion, double dt, double longest);

  /// Adds motion during which no image is used. @param dt s, above 0
  void wait(const Pose& increment, double dt);
  /// Whether motion has been added since the last call of endWaiting().
  bool isWaiting() const { return waiting_time_ > 0; }
  /// All motion that was added, in one step.
  OdometryStep waited() const;
  void endWaiting();

  /// Learns from an update. @param trusted false: the motion is forgotten
  void update(const UpdateReport& report, bool trusted);
  /// The pose has moved without odometry, or was given anew: waiting motion is forgotten, and the
  /// next update teaches nothing.
  void interrupt();
  const OdometryCalibration& calibration() const { return calibration_; }

 private:
  OdometryStep corrected(const Pose& increment, double dt) const;

  FilterParameters params_;
  OdometryCalibration calibration_;
  std::optional<Pose> last_reading_;
  double carried_for_ = 0;  // s without a reading
  Pose waiting_ = Pose::Identity();
  double waiting_time_ = 0, last_step_ = 0;  // s
  // Odometry since the last update as it was reported; none: a reading was missing.
  std::optional<Pose> since_update_;
  double time_since_update_ = 0;                  // s
  Vector6 noise_since_update_ = Vector6::Zero();  // variance, without the factor
};

}  // namespace edge_mcl
