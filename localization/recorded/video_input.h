/// A video as input of the localizer.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// Reads a video file by OpenCV. The camera is the base. The time of the first image is 0.
class VideoInput : public RecordedInput {
 public:
  /// @param camera calibration for the size of the images.
  /// @throws InputError when the file is not a video that OpenCV reads
  VideoInput(const std::string& file, const CameraModel& camera);
  ~VideoInput() override;

  /// The number that the file states; some files state a wrong one.
  size_t imageCount() const override;
  const std::optional<PoseGaussian>& initialPose() const override { return none_; }
  const Trajectory& truth() const override { return truth_; }
  /// Tells after the last image that the file states more images than could be read.
  std::string damage() const override;
  bool next(LiveInput* input, std::string* problem) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::optional<PoseGaussian> none_;
  Trajectory truth_;
};

}  // namespace edge_mcl
