/// Starts the viewer without its class, so that programs compile fast.
#pragma once

namespace ros {
class NodeHandle;
}

namespace edge_mcl {

/// Runs the viewer node until ROS shuts down, the window is closed, or `moments` moments are
/// recorded. @throws ParameterError, InputError, Error
void runViewer(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

}  // namespace edge_mcl
