/// Writes recordings as ROS bags.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

/// Writes a bag with the topics of nodes/messages/recording_messages.h and with /tf (odometry). At
/// the beginning it writes /tf_static (extrinsics) and /initialpose. The file is FILE.active until
/// close() renames it.
///
/// ROS has no time before 1 s. So a recording that begins before 1 s is shifted by 1 s.
class BagWriter : public Recorder {
 public:
  /// @param file must not exist yet.
  /// @throws InputError when it exists or cannot be written
  BagWriter(const std::string& file, const RecordingSetup& setup);
  ~BagWriter() override;
  void write(const RecordedFrame& frame) override;
  void writeDepth(double time, const cv::Mat& depth) override;
  void writeImu(const std::vector<ImuReading>& readings) override;
  void close() override;
  size_t count() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
