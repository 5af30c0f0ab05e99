/// Reading of the plain text files of a sequence.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// A pose with its time.
struct StampedPose {
  double time = 0;        ///< seconds
  std::string time_text;  ///< as written in the file, so that output carries the same digits
  Pose pose = Pose::Identity();
};
using Trajectory = std::vector<StampedPose>;

/// Reads "timestamp tx ty tz qx qy qz qw" lines ('#' starts a comment).
/// @throws InputError naming file and line of the first fault (too few numbers, not finite, no unit
/// quaternion, time going backwards).
Trajectory readTrajectory(const std::string& file);

/// One line of a TUM trajectory, without newline.
std::string formatPose(const std::string& time_text, const Pose& pose);

/// `timestamp filename`
struct StampedFile {
  double time = 0;
  std::string time_text;
  std::string file;
};
/// @throws InputError on malformed lines. Times are not checked here.
std::vector<StampedFile> readFileList(const std::string& file);

}  // namespace edge_mcl
