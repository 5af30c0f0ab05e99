// edge_mcl_mavros: gives the localizer's poses to an autopilot through MAVROS.
#include <ros/spinner.h>

#include "edge_mcl/nodes/common/node_main.h"
#include "edge_mcl/nodes/mavros/mavros_node.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_mavros", [] {
    const edge_mcl::MavrosNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    ros::spin();
  });
}
