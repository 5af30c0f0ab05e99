/// Starts the localizer without its class, so that programs compile fast.
#pragma once

#include <memory>

namespace ros {
class NodeHandle;
}

namespace edge_mcl {

/// Runs the node until ROS ends. @throws ParameterError, InputError
void runLocalizer();
/// Makes the node, which works until the pointer is released. @throws ParameterError, InputError
std::shared_ptr<void> startLocalizer(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

}  // namespace edge_mcl
