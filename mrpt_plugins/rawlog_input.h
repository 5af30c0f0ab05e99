/// An MRPT rawlog as input of the localizer.
#pragma once

#include <memory>

#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

/// Reads actions and sensory frames, or single observations, in the order of the file: images (with
/// their masks), range images, odometry (2D or 3D, of actions or observations) and, as ground
/// truth, CObservationRobotPose. A single image and a single range image of the same time are one
/// moment. In a file without images the range images are the moments. Images in files of their own
/// are looked for where MRPT puts them: X_Images/ beside X.rawlog, or Images/.
class RawlogInput : public RecordedInput {
 public:
  /// Reads the file once for its truth and the number of images. @param camera calibration of
  /// images that come without. @throws InputError when it is no rawlog or has neither images nor,
  /// with `depths`, range images.
  RawlogInput(const std::string& file, bool masks, bool depths,
              const std::optional<CameraModel>& camera = std::nullopt);
  ~RawlogInput() override;
  size_t imageCount() const override;
  /// A rawlog does not say.
  const std::optional<PoseGaussian>& initialPose() const override;
  const Trajectory& truth() const override;
  /// Whether the file ends amid an object.
  std::string damage() const override;
  size_t rangeCount() const;
  bool next(LiveInput* input, std::string* problem) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
