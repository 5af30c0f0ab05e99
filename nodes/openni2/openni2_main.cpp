// edge_mcl_openni2: the node that publishes a depth camera through OpenNI2.
#include "edge_mcl/nodes/common/node_main.h"
#include "edge_mcl/nodes/openni2/openni2_run.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_openni2", edge_mcl::runOpenNi2);
}
