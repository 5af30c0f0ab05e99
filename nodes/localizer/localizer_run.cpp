#include "edge_mcl/nodes/localizer/localizer_run.h"

#include <ros/ros.h>

#include "edge_mcl/nodes/localizer/localizer_node.h"

namespace edge_mcl {

void runLocalizer() {
  const LocalizerNode node{ros::NodeHandle(), ros::NodeHandle("~")};
  // Three threads, because images, services and odometry must not wait for each other.
  ros::MultiThreadedSpinner(3).spin();
}

std::shared_ptr<void> startLocalizer(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh) {
  return std::make_shared<LocalizerNode>(nh, private_nh);
}

}  // namespace edge_mcl
