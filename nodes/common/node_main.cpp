#include "edge_mcl/nodes/common/node_main.h"

#include <ros/ros.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/heap_blocks.h"

namespace edge_mcl {

int runNode(int argc, char** argv, const char* name, const std::function<void()>& node) {
  giveLargeBlocksBack();
  ros::init(argc, argv, name);
  // Messages are published as long as a handle exists.
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
