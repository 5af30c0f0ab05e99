#include "edge_mcl/nodes/openni2/openni2_run.h"

#include <ros/ros.h>

#include "edge_mcl/nodes/openni2/openni2_node.h"

namespace edge_mcl {

void runOpenNi2() {
  OpenNi2Node node{ros::NodeHandle(), ros::NodeHandle("~")};
  node.run();
}

}  // namespace edge_mcl
