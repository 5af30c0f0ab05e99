// edge_mcl_localizer: the localizer as a node.
#include <ros/ros.h>

#include "edge_mcl/core/error.h"
#include "edge_mcl/nodes/localizer_node.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "edge_mcl_localizer");
  // While a handle is there, messages still reach the console and rosout.
  const ros::NodeHandle keep_alive;
  try {
    const edge_mcl::LocalizerNode node{ros::NodeHandle(), ros::NodeHandle("~")};
    // Images, services and odometry must not wait for each other.
    ros::MultiThreadedSpinner(3).spin();
    return 0;
  } catch (const edge_mcl::ParameterError& e) {
    ROS_FATAL("%s", e.what());
    return 2;
  } catch (const std::exception& e) {
    ROS_FATAL("%s", e.what());
    return 3;
  }
}
