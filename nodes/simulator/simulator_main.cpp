// edge_mcl_simulator: the node that simulates a flight through a model.
#include "edge_mcl/nodes/common/node_main.h"
#include "edge_mcl/nodes/simulator/simulator_run.h"

int main(int argc, char** argv) {
  return edge_mcl::runNode(argc, argv, "edge_mcl_simulator", edge_mcl::runSimulator);
}
