// edge_mcl_localizer: the localizer as a node.
#include "edge_mcl/nodes/common/node_main.h"
#include "edge_mcl/nodes/localizer/localizer_run.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_localizer", edge_mcl::runLocalizer);
}
