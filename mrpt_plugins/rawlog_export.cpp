#include "edge_mcl/mrpt_plugins/rawlog_export.h"

#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cmath>

#include "edge_mcl/core/image_edges.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

namespace edge_mcl {

mrpt::obs::CActionCollection::Ptr makeAction(const SequenceFrame& from, const SequenceFrame& to,
                                             const Pose& T_base_camera,
                                             const FilterParameters& noise) {
  const double dt = to.time - from.time;
  PoseGaussian change;
  double position = 0, angle = 0;
  if (from.odometry && to.odometry) {
    const Pose of_camera = from.odometry->inverse() * *to.odometry;
    change.mean = normalized(T_base_camera * of_camera * T_base_camera.inverse());
    const double root = std::sqrt(dt / 0.1);
    position = noise.odometry_noise_position * root +
               noise.odometry_noise_per_metre * change.mean.translation().norm();
    angle = noise.odometry_noise_angle_deg * M_PI / 180 * root +
            noise.odometry_noise_per_radian * logSo3(change.mean.linear()).norm();
  } else {
    position = noise.walk_position_rate * std::sqrt(dt) + noise.walk_acceleration * dt * dt / 2;
    angle = M_PI / 180 *
            (noise.walk_angle_rate_deg * std::sqrt(dt) +
             noise.walk_angular_acceleration_deg * dt * dt / 2);
  }
  change.covariance.diagonal().head<3>().setConstant(position * position);
  change.covariance.diagonal().tail<3>().setConstant(angle * angle);

  mrpt::obs::CActionRobotMovement3D movement;
  movement.timestamp = mrpt::Clock::fromDouble(to.time);
  movement.poseChange.mean = toMrpt(change.mean);
  movement.poseChange.cov = toMrptCovariance(change);
  movement.rawOdometryIncrementReading = movement.poseChange.mean;
  auto actions = std::make_shared<mrpt::obs::CActionCollection>();
  actions->insert(movement);
  return actions;
}

mrpt::obs::CSensoryFrame::Ptr makeSensoryFrame(const Sequence& sequence, const SequenceFrame& frame,
                                               const Pose& T_base_camera, bool with_mask) {
  auto image = std::make_shared<CObservationMaskedImage>();
  image->timestamp = mrpt::Clock::fromDouble(frame.time);
  image->sensorLabel = "camera";
  image->cameraPose = toMrpt(T_base_camera);
  image->cameraParams = toMrpt(sequence.camera);
  image->image = mrpt::img::CImage(
      toGrey(readImage(frame.image_file, sequence.camera), frame.image_file), mrpt::img::DEEP_COPY);
  if (with_mask && !frame.mask_file.empty())
    image->ignore_mask =
        mrpt::img::CImage(readImage(frame.mask_file, sequence.camera, true), mrpt::img::DEEP_COPY);
  auto sensory_frame = std::make_shared<mrpt::obs::CSensoryFrame>();
  sensory_frame->insert(image);
  if (frame.ground_truth) {
    auto truth = std::make_shared<mrpt::obs::CObservationRobotPose>();
    truth->timestamp = image->timestamp;
    truth->sensorLabel = "ground_truth";
    truth->pose.mean = toMrpt(*frame.ground_truth * T_base_camera.inverse());
    truth->pose.cov.setZero();
    sensory_frame->insert(truth);
  }
  return sensory_frame;
}

}  // namespace edge_mcl
