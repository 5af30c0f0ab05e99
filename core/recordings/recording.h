/// What is written when a flight is recorded, whatever the format of the recording.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// One moment of a recording; what exists of it.
struct RecordedFrame {
  double time = 0;               ///< seconds
  cv::Mat color;                 ///< CV_8UC3 (blue, green, red) or CV_8U
  cv::Mat depth;                 ///< CV_16U, RecordingSetup::depth_scale units per metre; or empty
  cv::Mat mask;                  ///< CV_8U, non-zero: not in the map; or empty
  std::optional<Pose> truth;     ///< T_map_camera
  std::optional<Pose> odometry;  ///< T_odom_camera
};

struct ImuReading {
  double time = 0;
  Eigen::Vector3d angular_velocity;  ///< body axes, rad/s
  Eigen::Vector3d specific_force;    ///< body axes, m/s^2: at rest +g along the body's up axis
};

/// What holds for all of a recording.
struct RecordingSetup {
  CameraModel camera;
  Pose T_base_camera = opticalOnBody();  ///< the base has x forward, z up
  double depth_scale = 5000;             ///< units of depth images per metre
  Pose initial_pose = Pose::Identity();  ///< T_map_camera where a localizer is told to start
  double initial_std_position = 0.1;     ///< m, per axis
  double initial_std_angle = 0.05;       ///< rad, per axis
};

/// Writes a recording, moment by moment. All methods throw InputError when something cannot be
/// written.
class Recorder {
 public:
  virtual ~Recorder() = default;
  /// Times must increase.
  virtual void write(const RecordedFrame& frame) = 0;
  /// A depth image with a time of its own. It and the IMU are ignored by formats that have no place
  /// for them.
  virtual void writeDepth(double, const cv::Mat&) {}
  virtual void writeImu(const std::vector<ImuReading>& readings) = 0;
  /// Completes the recording; nothing may be written afterwards.
  virtual void close() = 0;
  /// Images written.
  virtual size_t count() const = 0;
};

/// Image, mask and poses of a sequence's frame, without depth. @throws InputError when a file
/// cannot be read.
RecordedFrame loadFrame(const Sequence& sequence, const SequenceFrame& frame);

/// What a recording made of the sequence says. @param T_base_camera as it shall be in it.
RecordingSetup setupOf(const Sequence& sequence, const Pose& T_base_camera);

}  // namespace edge_mcl
