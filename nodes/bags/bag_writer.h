/// Recordings as ROS bags.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

/// Topics: see nodes/messages/recording_messages.h; besides /tf (odometry), /tf_static (mounting)
/// and /initialpose at the beginning. Written as FILE.active, renamed by close().
///
/// ROS knows no time before 1 s: a recording that begins earlier is shifted by one second.
class BagWriter : public Recorder {
 public:
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
