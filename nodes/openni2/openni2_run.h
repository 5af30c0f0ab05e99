/// Starts the driver of depth cameras without its class, so that programs compile fast.
#pragma once

namespace edge_mcl {

/// Runs the node until ROS ends. @throws ParameterError, InputError
void runOpenNi2();

}  // namespace edge_mcl
