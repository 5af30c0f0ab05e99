// edge_mcl_detector: the node that makes masks of objects that are not in the map.
#include "edge_mcl/nodes/common/node_main.h"
#include "edge_mcl/nodes/detector/detector_run.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_detector", edge_mcl::runDetector);
}
