/// A recorded sequence: a directory in the layout of the TUM RGB-D benchmark, with a model in it.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

/// Files and poses of one image of a sequence. Parts that do not exist are empty.
struct SequenceFrame {
  double time = 0;        ///< seconds
  std::string time_text;  ///< as written in rgb.txt
  std::string image_file;
  std::string mask_file;             ///< nearest in time; empty: none within 5 ms
  std::string depth_file;            ///< nearest in time; empty: none within 25 ms
  std::optional<Pose> odometry;      ///< T_odom_camera
  std::optional<Pose> ground_truth;  ///< T_map_camera, within 5 ms
};

/// A sequence without the pixels of its images.
struct Sequence {
  std::string directory, name;
  CameraModel camera;
  std::string model_file;             ///< empty when the directory has no model.obj
  std::optional<Pose> initial_pose;   ///< T_map_camera; none: the pose must be searched
  double initial_std_position = 0.1;  ///< standard deviation of the initial pose, m, per axis
  double initial_std_angle = 0.05;    ///< standard deviation of the initial pose, rad, per axis
  double depth_scale = 5000;          ///< units of depth images per metre
  std::vector<SequenceFrame> frames;
  std::vector<StampedFile> depths;  ///< all depth images, with times of their own
  bool has_odometry = false;
  std::vector<std::string> warnings;  ///< e.g. about images left out because their time goes back
};

/// Reads rgb.txt, camera.yaml and, where present, sequence.yaml, mask.txt, depth.txt, odometry.txt
/// and groundtruth.txt. Images whose time does not increase are left out with a warning. Odometry
/// is interpolated to the times of the images. Warnings tell when masks, depth images or odometry
/// fit no image, and when masks or odometry are missing for some images.
/// The folders of other programs that readForeignFolder() knows are read as well.
/// @param camera_file calibration; empty: camera.yaml, or that of the folder.
/// @throws InputError that names file and fault.
Sequence readSequence(const std::string& directory, const std::string& camera_file = "");

/// Replaces the masks of a sequence by those that DIRECTORY/mask.txt lists. A warning tells how
/// many images have no mask there.
/// @throws InputError when the list cannot be read or no image has a mask in it.
void useMasks(const std::string& directory, Sequence* sequence);

/// Initial pose of a sequence, T_map_camera. @throws InputError when there is none.
const Pose& startOf(const Sequence& sequence);

/// Reads an image, with the channels and bits of the file.
/// @throws InputError when it cannot be decoded or its size differs from the camera's.
cv::Mat readImage(const std::string& file, const CameraModel& camera);
/// Reads a mask of any number of channels and bits. The result is CV_8U, 255 where any colour is
/// not zero. An alpha channel does not count.
/// @throws InputError, see readImage().
cv::Mat readMask(const std::string& file, const CameraModel& camera);
/// Reads a depth image with one channel of 16 bits.
/// @throws InputError, see readImage(), or when the type differs.
cv::Mat readDepth(const std::string& file, const CameraModel& camera);

}  // namespace edge_mcl
