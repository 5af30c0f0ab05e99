/// The part that the main functions of all nodes share.
#pragma once

#include <functional>

namespace edge_mcl {

/// Starts ROS and runs a node. An exception becomes one line on the console and in rosout.
/// @return exit code: 0 done, 2 wrong parameters, 3 broken input
int runNode(int argc, char** argv, const char* name, const std::function<void()>& node);

}  // namespace edge_mcl
