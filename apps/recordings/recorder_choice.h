/// Chooses the format of a recording by the name of its file.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

/// Makes a recorder: a ROS bag for a file `*.bag`, an MRPT rawlog for a file `*.rawlog`.
/// @param noise odometry noise that is written with the actions of a rawlog.
/// @return null for any other name.
/// @throws InputError when the file cannot be written, or when it is a bag and this build has no
/// ROS
std::unique_ptr<Recorder> recorderForFile(const std::string& file, const RecordingSetup& setup,
                                          const FilterParameters& noise);

}  // namespace edge_mcl
