/// What maps are made from: recordings with depth and poses, and scans.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/recordings/recording_options.h"
#include "edge_mcl/core/recordings/text_table.h"
#include "edge_mcl/mapping/depth_segments.h"

namespace edge_mcl {

/// The images of a recording that a map needs: with depth, with a pose, and with some motion since
/// the last one.
class MappingRecording {
 public:
  /// @param poses_file trajectory of the poses (T_map_camera for a directory, else T_map_base);
  ///   empty: the ground truth of the recording.
  /// @throws InputError when there are no poses.
  MappingRecording(const RecordingOptions& options, const std::string& poses_file);

  /// Number of images of the recording.
  size_t imageCount() const { return input_->imageCount(); }
  /// Reads the next moment. @return false at the end.
  bool next();
  /// The image of this moment, if a map needs it.
  const std::optional<MappingImage>& image() const { return image_; }
  /// Camera of the images. Set after the first image.
  const std::optional<CameraModel>& camera() const { return camera_; }
  size_t used() const { return used_; }

 private:
  std::optional<Pose> poseAt(double time) const;
  bool hasMoved(const Pose& pose) const;

  std::unique_ptr<RecordedInput> input_;
  Trajectory poses_;
  std::optional<CameraModel> camera_;
  std::optional<MappingImage> image_;
  std::optional<Pose> last_;
  size_t used_ = 0;
};

}  // namespace edge_mcl
