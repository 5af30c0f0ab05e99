/// A random flight through a building in which something goes wrong, moment by moment.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {

enum class TrialKind {
  kGlobal,    ///< nothing is known at the start
  kOffset,    ///< the start is known badly
  kKidnap,    ///< carried elsewhere, unnoticed by the odometry
  kBlackout,  ///< no light for a while, and the odometry drifts
  kTrack      ///< nothing goes wrong
};

/// @throws ParameterError on an unknown name.
TrialKind trialKind(const std::string& name);

class TrialFlight {
 public:
  /// @param images of the flight. @param event number of the image at which it goes wrong (kidnap,
  /// blackout). @throws InputError
  TrialFlight(const std::string& scenario, TrialKind kind, uint64_t seed, double rate,
              size_t images, size_t event, double blackout_seconds, double drift);

  const CameraModel& camera() const { return first_->scenario().camera; }
  double depthScale() const { return first_->scenario().depth_scale; }  ///< units per metre
  /// The next image, with depth, truth, odometry (T_odom_camera), mask. @return false at the end.
  bool next(RecordedFrame* frame);

 private:
  TrialKind kind_;
  double rate_, drift_;
  size_t images_, event_, dark_, taken_ = 0;
  RandomSource random_;
  std::unique_ptr<Simulator> first_, second_;
  Eigen::Vector3d drift_direction_;
  Pose odometry_ = Pose::Identity();
  std::optional<Pose> last_raw_;
};

}  // namespace edge_mcl
