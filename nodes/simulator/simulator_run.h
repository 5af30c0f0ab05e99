/// Starts the simulator without its class, so that programs compile fast.
#pragma once

namespace edge_mcl {

/// Runs the node until ROS ends. @throws ParameterError, InputError
void runSimulator();

}  // namespace edge_mcl
