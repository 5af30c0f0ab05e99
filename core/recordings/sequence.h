/// A recorded sequence: a directory in the layout of the TUM RGB-D benchmark with a map beside it.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

/// One image of a sequence; what exists of it.
struct SequenceFrame {
  double time = 0;        ///< seconds
  std::string time_text;  ///< as in rgb.txt
  std::string image_file;
  std::string mask_file;             ///< empty: none
  std::string depth_file;            ///< nearest in time; empty: none within 25 ms
  std::optional<Pose> odometry;      ///< T_odom_camera
  std::optional<Pose> ground_truth;  ///< T_map_camera
};

/// Everything but the pixels.
struct Sequence {
  std::string directory, name;
  CameraModel camera;
  std::string model_file;             ///< empty when the directory holds none
  std::optional<Pose> initial_pose;   ///< T_map_camera; none: to be looked for
  double initial_std_position = 0.1;  ///< m, per axis
  double initial_std_angle = 0.05;    ///< rad, per axis
  double depth_scale = 5000;          ///< units of the depth images per metre
  std::vector<SequenceFrame> frames;
  std::vector<StampedFile> depths;  ///< depth images, with times of their own
  bool has_odometry = false;
  std::vector<std::string> warnings;  ///< e.g. frames left out because their time goes back
};

/// Reads rgb.txt, camera.yaml and, where present, sequence.yaml, mask.txt, depth.txt, odometry.txt,
/// groundtruth.txt. Images whose time does not increase are left out with a warning; odometry at
/// other times than the images' is interpolated; lists that belong to no image are warned of, and
/// images without the mask or odometry that others have.
/// @throws InputError naming file and fault.
Sequence readSequence(const std::string& directory);

/// Replaces the masks by those that DIRECTORY/mask.txt lists; warns of images that have none there.
/// @throws InputError when the list cannot be read or no image has a mask in it.
void useMasks(const std::string& directory, Sequence* sequence);

/// The sequence's initial pose. @throws InputError when it has none.
const Pose& startOf(const Sequence& sequence);

/// Reads an image. @throws InputError when it cannot be decoded or its size differs from the
/// camera's.
cv::Mat readImage(const std::string& file, const CameraModel& camera);
/// The same for a mask, of any number of channels and bits: 255 where any colour is not zero.
cv::Mat readMask(const std::string& file, const CameraModel& camera);
/// The same for a depth image: 16 bits.
cv::Mat readDepth(const std::string& file, const CameraModel& camera);

}  // namespace edge_mcl
