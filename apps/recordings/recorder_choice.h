/// The recorder for a file name.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

/// `*.bag`: a ROS bag; `*.rawlog`: an MRPT rawlog; null for anything else.
/// @param noise of the rawlog's actions. @throws InputError when it cannot be written, or a bag is
/// wanted of a build without ROS.
std::unique_ptr<Recorder> recorderForFile(const std::string& file, const RecordingSetup& setup,
                                          const FilterParameters& noise);

}  // namespace edge_mcl
