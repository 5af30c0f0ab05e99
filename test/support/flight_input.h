/// Inputs of the localizer from simulated flights.
#pragma once

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/localization/search/pose_sharpener.h"
#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl::test {

/// The direction up as an IMU measures it, with a standard deviation of one degree.
inline UpReading upOf(const Pose& truth, RandomSource* random) {
  UpReading up;
  up.sigma = 1 * kDegree;
  const Eigen::Vector3d error =
      up.sigma * Eigen::Vector3d(random->normal(), random->normal(), random->normal());
  up.up_base = expSo3(error) * (truth.linear().transpose() * Eigen::Vector3d::UnitZ());
  return up;
}

inline LiveInput inputOf(const RecordedFrame& frame, const CameraModel& camera,
                         RandomSource* random) {
  LiveInput input;
  input.time = frame.time;
  input.odometry = frame.odometry;
  input.up = upOf(*frame.truth, random);
  LiveInput::CameraImage view;
  view.camera = camera;
  view.image = frame.color;
  view.mask = frame.mask;
  view.origin = "image";
  input.images = {view};
  return input;
}

inline bool isRight(const Pose& pose, const Pose& truth) {
  return isNear(pose, truth, 0.25, 5 * kDegree);
}

}  // namespace edge_mcl::test
