// edge_mcl_simulator: a flight through a model, as a node.
#include <ros/ros.h>

#include "edge_mcl/core/error.h"
#include "edge_mcl/nodes/simulator_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "edge_mcl_simulator");
  // While a handle is there, messages still reach the console and rosout.
  const ros::NodeHandle keep_alive;
  try {
    edge_mcl::SimulatorNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    ros::AsyncSpinner spinner(1);
    spinner.start();
    node.run();
    return 0;
  } catch (const edge_mcl::ParameterError& e) {
    ROS_FATAL("%s", e.what());
    return 2;
  } catch (const std::exception& e) {
    ROS_FATAL("%s", e.what());
    return 3;
  }
}
