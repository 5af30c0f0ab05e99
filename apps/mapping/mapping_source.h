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

/// The image and the depth of a moment, where the depth is as the camera of the image sees it.
/// Masked pixels have no depth, because what a mask hides moves.
/// @return none: the moment lacks one of them
std::optional<MappingImage> mappingImageOf(const LiveInput& input, const Pose& T_map_base);

/// The pose of a trajectory at a time, s, between two neighbours that are at most 0.2 s apart.
std::optional<Pose> poseAt(const Trajectory& poses, double time);

/// Tells whether a camera has moved since the last pose that was taken. Images from one place show
/// the same errors, so a line needs views from several places.
class MotionGate {
 public:
  /// @return whether the pose is taken
  bool take(const Pose& pose);

 private:
  std::optional<Pose> last_;
};

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
  /// Origin of the images' poses in the coordinates of the trajectory, m: fused surfaces are in
  /// single precision. Zero within 5 km.
  const Eigen::Vector3d& origin() const { return origin_; }

 private:
  std::unique_ptr<RecordedInput> input_;
  Trajectory poses_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::optional<CameraModel> camera_;
  std::optional<MappingImage> image_;
  MotionGate gate_;
  size_t used_ = 0;
};

}  // namespace edge_mcl
