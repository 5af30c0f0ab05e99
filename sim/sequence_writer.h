/// Writes a sequence directory, image by image, so that it is readable at any time.
#pragma once

#include <fstream>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/camera_model.h"
#include "edge_mcl/core/se3.h"
#include "edge_mcl/sim/sensor_noise.h"

namespace edge_mcl {

/// One moment of a flight.
struct RecordedFrame {
  double time = 0;
  cv::Mat color;  ///< CV_8UC3
  cv::Mat depth;  ///< CV_16U
  cv::Mat mask;   ///< CV_8U
  Pose truth, odometry;
};

/// What sequence.yaml says.
struct SequenceDescription {
  double depth_scale = 5000;             ///< units per metre
  Pose initial_pose = Pose::Identity();  ///< where a localizer is told to start
  double initial_std_position = 0.1;     ///< m, per axis
  double initial_std_angle = 0.05;       ///< rad, per axis
  std::vector<std::string> notes;        ///< without quotes
};

/// The layout is that of docs/sequences.md, with depth and imu.txt. An image is listed once its
/// file is complete, so an interrupted recording is a valid, shorter one.
class SequenceWriter {
 public:
  /// @param directory is made; must not hold a sequence already. @throws InputError when something
  /// cannot be written; the same from all methods.
  SequenceWriter(std::string directory, const CameraModel& camera, const std::string& model_file,
                 const SequenceDescription& about);
  void write(const RecordedFrame& frame);
  void writeImu(const std::vector<ImuReading>& readings);
  size_t count() const { return count_; }

 private:
  void writeFile(const std::string& name, const std::vector<uint8_t>& bytes);
  void writeText(const std::string& name, const std::string& text);
  void writeImage(const std::string& name, const cv::Mat& image);
  void append(std::ofstream* list, const std::string& name, const std::string& line);
  std::string directory_;
  std::ofstream rgb_, depth_, mask_, truth_, odometry_;
  size_t count_ = 0;
};

}  // namespace edge_mcl
