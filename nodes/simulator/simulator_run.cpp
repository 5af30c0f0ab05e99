#include "edge_mcl/nodes/simulator/simulator_run.h"

#include <ros/ros.h>

#include "edge_mcl/nodes/simulator/simulator_node.h"

namespace edge_mcl {

void runSimulator() {
  SimulatorNode node{ros::NodeHandle(), ros::NodeHandle("~")};
  ros::AsyncSpinner spinner(1);
  spinner.start();
  node.run();
}

}  // namespace edge_mcl
