/// An MRPT rawlog as input of the localizer.
#pragma once

#include <memory>

#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// Reads a rawlog in the order of the file. The rawlog may hold actions and sensory frames, or
/// single observations.
///
/// It reads images with their masks, range images, odometry (2D or 3D, from actions or
/// observations), and CObservationRobotPose as ground truth. An image and a range image that stand
/// alone and have the same time make one moment. In a file without images each range image makes a
/// moment. Images in separate files are searched where MRPT writes them: in X_Images/ beside
/// X.rawlog, or in Images/.
class RawlogInput : public RecordedInput {
 public:
  /// Reads the whole file once, for the ground truth and the number of images.
  /// @param masks, depths whether masks and range images are used. @param camera calibration of
  /// images that have none. @throws InputError when the file cannot be read, is no rawlog, or has
  /// no images (with `depths`: neither images nor range images).
  RawlogInput(const std::string& file, bool masks, bool depths,
              const std::optional<CameraModel>& camera = std::nullopt);
  ~RawlogInput() override;
  /// Number of images; in a file without images, number of range images.
  size_t imageCount() const override;
  /// Always empty, because a rawlog holds no initial pose.
  const std::optional<PoseGaussian>& initialPose() const override;
  const Trajectory& truth() const override;
  /// One line if the file ends in the middle of an object, otherwise empty.
  std::string damage() const override;
  /// Number of range images.
  size_t rangeCount() const;
  bool next(LiveInput* input, std::string* problem) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
