#include "edge_mcl/nodes/detector/detector_run.h"

#include <ros/ros.h>

#include "edge_mcl/nodes/detector/detector_node.h"

namespace edge_mcl {

void runDetector() {
  const DetectorNode node{ros::NodeHandle(), ros::NodeHandle("~")};
  ros::spin();
}

std::shared_ptr<void> startDetector(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh) {
  return std::make_shared<DetectorNode>(nh, private_nh);
}

}  // namespace edge_mcl
