/// Starts the detector without its class, so that programs compile fast.
#pragma once

#include <memory>

namespace ros {
class NodeHandle;
}

namespace edge_mcl {

/// Runs the node until ROS ends. @throws ParameterError, InputError
void runDetector();
/// Makes the node, which works until the pointer is released. @throws ParameterError, InputError
std::shared_ptr<void> startDetector(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

}  // namespace edge_mcl
