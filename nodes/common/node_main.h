/// What all nodes' main functions share.
#pragma once

#include <ros/ros.h>

#include <functional>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/heap_blocks.h"

namespace edge_mcl {

/// Runs a node; what it throws becomes one line on the console and in rosout. @return exit code: 2
/// for wrong parameters, 3 for broken input.
inline int runNode(int argc, char** argv, const char* name, const std::function<void()>& node) {
  giveLargeBlocksBack();
  ros::init(argc, argv, name);
  // While a handle is there, messages still get out.
  const ros::NodeHandle keep_alive;
  try {
    node();
    return 0;
  } catch (const ParameterError& e) {
    ROS_FATAL("%s", e.what());
    return 2;
  } catch (const std::exception& e) {
    ROS_FATAL("%s", e.what());
    return 3;
  }
}

}  // namespace edge_mcl
