// edge_mcl_localizer: the localizer as a node.
#include "edge_mcl/nodes/common/node_main.h"
#include "edge_mcl/nodes/localizer/localizer_node.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_localizer", [] {
    const edge_mcl::LocalizerNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    // Three threads, because images, services and odometry must not wait for each other.
    ros::MultiThreadedSpinner(3).spin();
  });
}
