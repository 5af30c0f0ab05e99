/// Reads and writes the plain text files of a sequence.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// A pose and its time.
struct StampedPose {
  double time = 0;        ///< seconds
  std::string time_text;  ///< as written in the file, so that output carries the same digits
  Pose pose = Pose::Identity();
};
using Trajectory = std::vector<StampedPose>;

/// Reads a trajectory: lines "timestamp tx ty tz qx qy qz qw" ('#' starts a comment).
/// @throws InputError that names file and line of the first fault: too few numbers, a number that
///   is not finite, a quaternion without unit length, or a time that does not increase.
Trajectory readTrajectory(const std::string& file);

/// Formats one line of a TUM trajectory, without newline.
std::string formatPose(const std::string& time_text, const Pose& pose);

/// One line `timestamp filename` of a list.
struct StampedFile {
  double time = 0;
  std::string time_text;
  std::string file;
};
/// Reads a list of files. The order of times is not checked.
/// @throws InputError when a line is malformed.
std::vector<StampedFile> readFileList(const std::string& file);

}  // namespace edge_mcl
