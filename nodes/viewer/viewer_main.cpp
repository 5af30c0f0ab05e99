// edge_mcl_viewer: the node that shows a running localizer.
#include <ros/node_handle.h>

#include "edge_mcl/nodes/common/node_main.h"
#include "edge_mcl/nodes/viewer/viewer_run.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_viewer",
                           [] { edge_mcl::runViewer(ros::NodeHandle(), ros::NodeHandle("~")); });
}
