/// Writes a sequence directory image by image. The directory is readable at any time.
#pragma once

#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

/// Writes the layout of docs/sequences.md, with depth and imu.txt. An image is listed only after
/// its file is complete, so an interrupted recording is a valid, shorter sequence.
class SequenceWriter : public Recorder {
 public:
  /// Makes the directory and writes model, camera and description. @param directory must not hold
  /// any file of a sequence. @param notes lines for sequence.yaml. @throws InputError otherwise, or
  /// when something cannot be written.
  SequenceWriter(std::string directory, const RecordingSetup& setup, const std::string& model_file,
                 const std::vector<std::string>& notes);
  /// Writes one image with its depth image, mask and poses. Only the poses may be missing.
  void write(const RecordedFrame& frame) override;
  void writeImu(const std::vector<ImuReading>& readings) override;
  void close() override {}
  size_t count() const override { return count_; }

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
