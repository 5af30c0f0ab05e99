// edge_mcl_detector: masks of what is not in the map, as a node.
#include "edge_mcl/nodes/detector_node.h"
#include "edge_mcl/nodes/node_main.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_detector", [] {
    const edge_mcl::DetectorNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    ros::spin();
  });
}
