/// Interface of all formats in which a flight is recorded.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Data of one moment of a recording. Parts that do not exist are empty.
struct RecordedFrame {
  double time = 0;               ///< seconds
  cv::Mat color;                 ///< CV_8UC3 (blue, green, red) or CV_8U
  cv::Mat depth;                 ///< CV_16U, RecordingSetup::depth_scale units per metre; or empty
  cv::Mat mask;                  ///< CV_8U, non-zero: not in the map; or empty
  std::optional<Pose> truth;     ///< ground truth, T_map_camera
  std::optional<Pose> odometry;  ///< T_odom_camera
};

/// One reading of an IMU.
struct ImuReading {
  double time = 0;                   ///< seconds
  Eigen::Vector3d angular_velocity;  ///< body axes, rad/s
  /// Body axes, m/s^2; at rest it is +g along the body's up axis.
  Eigen::Vector3d specific_force;
};

/// Settings of a whole recording.
struct RecordingSetup {
  CameraModel camera;
  Pose T_base_camera = opticalOnBody();  ///< the base has x forward, z up
  double depth_scale = 5000;             ///< units of depth images per metre
  Pose initial_pose = Pose::Identity();  ///< T_map_camera at which a localizer starts
  double initial_std_position = 0.1;     ///< of the initial pose, m, per axis
  double initial_std_angle = 0.05;       ///< of the initial pose, rad, per axis
};

/// Writes a recording, moment by moment. All methods throw InputError when something cannot be
/// written.
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// Writes one moment. Times must increase.
  virtual void write(const RecordedFrame& frame) = 0;
  /// Writes a depth image with a time of its own, seconds. Formats that have no place for it ignore
  /// it.
  virtual void writeDepth(double, const cv::Mat&) {}
  /// Writes readings of an IMU. Formats that have no place for them ignore them.
  virtual void writeImu(const std::vector<ImuReading>& readings) = 0;
  /// Completes the recording. Nothing may be written afterwards.
  virtual void close() = 0;
  /// Number of images that were written.
  virtual size_t count() const = 0;
};

/// Loads image, mask and poses of one frame of a sequence, without its depth image.
/// @throws InputError when a file cannot be read.
RecordedFrame loadFrame(const Sequence& sequence, const SequenceFrame& frame);

/// Settings of a recording that is made from a sequence.
/// @param T_base_camera extrinsics of the recording.
/// @throws InputError when the sequence has no initial pose.
RecordingSetup setupOf(const Sequence& sequence, const Pose& T_base_camera);

}  // namespace edge_mcl
