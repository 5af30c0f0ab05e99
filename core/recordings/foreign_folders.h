/// Folders with recordings that other programs wrote.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

/// What the files of a recording list, before it is joined by time.
struct SequenceLists {
  std::string origin;               ///< of the images, named in errors
  std::vector<StampedFile> images;  ///< with their directories
  std::vector<StampedFile> masks;   ///< in the order of time
  Trajectory odometry;              ///< T_odom_camera
  Trajectory truth;                 ///< T_map_camera
};

/// Joins lists by time and adds the frames to a sequence. `depths` of the sequence is set already.
/// @throws InputError when there is no image
void fillFrames(const SequenceLists& lists, Sequence* sequence);

/// Reads a folder of one of these kinds, when it has no rgb.txt:
///  - EuRoC (ASL): mav0/cam0/data.csv, sensor.yaml, and the ground truth where it is there;
///  - KITTI odometry: image_0 or image_2, times.txt, calib.txt;
///  - photographs: images in the folder itself, in the order of their names. A name that is a
///  number
///    of ten digits or more is the time; otherwise ten images per second are assumed, with a
///    warning.
/// @param camera_file calibration; empty: that of the folder.
/// @param sequence its directory and its description are set.
/// @return false when the folder is none of these.
/// @throws InputError when the folder is one of these but cannot be read, or was recorded by ROS 2.
bool readForeignFolder(const std::string& camera_file, Sequence* sequence);

}  // namespace edge_mcl
