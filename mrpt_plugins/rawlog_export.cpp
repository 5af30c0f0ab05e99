#include "edge_mcl/mrpt_plugins/rawlog_export.h"

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/image_edges.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

namespace edge_mcl {

namespace {

/// Time of an image, and its pose by odometry.
struct Moment {
  double time;                          ///< seconds
  const std::optional<Pose>& odometry;  ///< T_odom_camera
};

mrpt::obs::CActionCollection::Ptr actionBetween(const Moment& from, const Moment& to,
                                                const Pose& T_base_camera,
                                                const FilterParameters& noise) {
  const double dt = to.time - from.time;
  PoseGaussian change;
  Vector6 sigma = walkNoise(noise, dt);
  if (from.odometry && to.odometry) {
    const Pose of_camera = from.odometry->inverse() * *to.odometry;
    change.mean = normalized(T_base_camera * of_camera * T_base_camera.inverse());
    sigma = odometryNoise(noise, change.mean, dt);
  }
  change.covariance = sigma.cwiseAbs2().asDiagonal();

  mrpt::obs::CActionRobotMovement3D movement;
  movement.timestamp = mrpt::Clock::fromDouble(to.time);
  movement.poseChange.mean = toMrpt(change.mean);
  movement.poseChange.cov = toMrptCovariance(change);
  movement.rawOdometryIncrementReading = movement.poseChange.mean;
  auto actions = std::make_shared<mrpt::obs::CActionCollection>();
  actions->insert(movement);
  return actions;
}

/// Makes a sensory frame of image, mask and ground truth. @param origin named in errors.
mrpt::obs::CSensoryFrame::Ptr sensoryFrameOf(const RecordedFrame& frame, const CameraModel& camera,
                                             const Pose& T_base_camera, const std::string& origin) {
  auto image = std::make_shared<CObservationMaskedImage>();
  image->timestamp = mrpt::Clock::fromDouble(frame.time);
  image->sensorLabel = "camera";
  image->cameraPose = toMrpt(T_base_camera);
  image->cameraParams = toMrpt(camera);
  image->image = mrpt::img::CImage(toGrey(frame.color, origin), mrpt::img::DEEP_COPY);
  if (!frame.mask.empty()) image->ignore_mask = mrpt::img::CImage(frame.mask, mrpt::img::DEEP_COPY);
  auto sensory_frame = std::make_shared<mrpt::obs::CSensoryFrame>();
  sensory_frame->insert(image);
  if (frame.truth) {
    auto truth = std::make_shared<mrpt::obs::CObservationRobotPose>();
    truth->timestamp = image->timestamp;
    truth->sensorLabel = "ground_truth";
    truth->pose.mean = toMrpt(*frame.truth * T_base_camera.inverse());
    truth->pose.cov.setZero();
    sensory_frame->insert(truth);
  }
  return sensory_frame;
}

}  // namespace

mrpt::obs::CActionCollection::Ptr makeAction(const SequenceFrame& from, const SequenceFrame& to,
                                             const Pose& T_base_camera,
                                             const FilterParameters& noise) {
  return actionBetween({from.time, from.odometry}, {to.time, to.odometry}, T_base_camera, noise);
}

mrpt::obs::CSensoryFrame::Ptr makeSensoryFrame(const Sequence& sequence, const SequenceFrame& frame,
                                               const Pose& T_base_camera, bool with_mask) {
  RecordedFrame loaded = loadFrame(sequence, frame);
  if (!with_mask) loaded.mask.release();
  return sensoryFrameOf(loaded, sequence.camera, T_base_camera, frame.image_file);
}

struct RawlogWriter::File {
  mrpt::io::CFileGZOutputStream stream;
};

RawlogWriter::RawlogWriter(const std::string& file, const RecordingSetup& setup,
                           const FilterParameters& noise)
    : name_(file), setup_(setup), noise_(noise), file_(std::make_unique<File>()) {
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) throw InputError(file + ": exists already");
  if (!file_->stream.open(partial())) throw InputError(file + ": cannot be written");
}

RawlogWriter::~RawlogWriter() = default;

void RawlogWriter::write(const RecordedFrame& frame) {
  if (!file_) throw Error(name_ + ": the rawlog is closed");
  const RecordedFrame& from = last_ ? *last_ : frame;
  try {
    auto archive = mrpt::serialization::archiveFrom(file_->stream);
    // MRPT expects pairs: first the motion up to this moment, then its observations.
    archive << *actionBetween({from.time, from.odometry}, {frame.time, frame.odometry},
                              setup_.T_base_camera, noise_)
            << *sensoryFrameOf(frame, setup_.camera, setup_.T_base_camera, name_);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError(partial() + ": cannot be written (disk full?); " + std::to_string(count_) +
                     " images are complete");
  }
  last_ = RecordedFrame{frame.time, {}, {}, {}, frame.truth, frame.odometry};
  ++count_;
}

void RawlogWriter::close() {
  if (!file_) return;
  file_->stream.close();
  file_.reset();
  std::error_code error;
  std::filesystem::rename(partial(), name_, error);
  if (error) throw InputError(name_ + ": cannot be written: " + error.message());
}

}  // namespace edge_mcl
