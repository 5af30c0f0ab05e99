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

/// Reads a trajectory: lines "timestamp tx ty tz qx qy qz qw" ('#' starts a comment). In a table
/// with commas the first line names the columns, and qw may come before qx, as in EuRoC's ground
/// truth. Stamps in milliseconds, microseconds or nanoseconds since 1970 become seconds.
/// @throws InputError that names file and line of the first fault: too few numbers, a number that
///   is not finite, a quaternion without unit length, or a time that does not increase.
Trajectory readTrajectory(const std::string& file);

/// Formats one line of a TUM trajectory, without newline.
std::string formatPose(const std::string& time_text, const Pose& pose);
/// First line of a trajectory in EuRoC's layout.
extern const char* const kEurocColumns;
/// Formats one line of it, without newline: nanoseconds, position, quaternion w first.
/// @param time_text seconds, as digits with an optional point. Other texts stay as they are.
std::string formatEurocPose(const std::string& time_text, const Pose& pose);

/// A stamp in seconds. Stamps in smaller units since 1970 become seconds, in the text as well.
/// @param where named in errors. @throws InputError when the text is not a number
double stampIn(std::string* text, const std::string& where);

/// One line `timestamp filename` of a list.
struct StampedFile {
  double time = 0;
  std::string time_text;
  std::string file;
};
/// Reads a list of files, separated by spaces or commas. Units of time are those of
/// readTrajectory(). The order of times is not checked.
/// @throws InputError when a line is malformed.
std::vector<StampedFile> readFileList(const std::string& file);

}  // namespace edge_mcl
