/// Simulates a random flight through a building with one fault, for trials of the localizer.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {

/// What goes wrong. kGlobal, kOffset and kTrack fly alike; only the start pose that the caller
/// gives to the localizer differs.
enum class TrialKind {
  kGlobal,    ///< the start pose is unknown
  kOffset,    ///< the start pose has a large error
  kKidnap,    ///< the robot is carried to another place, and the odometry does not notice
  kBlackout,  ///< images are black for a while, and the odometry drifts
  kTrack      ///< nothing goes wrong
};

/// Returns the kind by its name: global, offset, kidnap, blackout or track.
/// @throws ParameterError for any other name.
TrialKind trialKind(const std::string& name);

/// A random flight with the fault of a trial.
class TrialFlight {
 public:
  /// @param scenario YAML file; its path is replaced by a random flight. @param rate images per
  /// second. @param images number of images. @param event number of the first image with the fault
  /// (kidnap, blackout). @param blackout_seconds duration of the blackout. @param drift error that
  /// the odometry gains during the blackout, m. @throws InputError when no flight is found or a
  /// file cannot be read.
  TrialFlight(const std::string& scenario, TrialKind kind, uint64_t seed, double rate,
              size_t images, size_t event, double blackout_seconds, double drift);

  const CameraModel& camera() const { return first_->scenario().camera; }
  double depthScale() const { return first_->scenario().depth_scale; }  ///< units per metre
  /// Gives the next image with depth, mask, ground truth and odometry (T_odom_camera).
  /// @return false at the end.
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
