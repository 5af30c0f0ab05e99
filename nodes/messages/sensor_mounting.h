/// Where a sensor is on the robot, by tf and odometry.
#pragma once

#include <std_msgs/Header.h>
#include <tf2/buffer_core.h>

#include <string>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// T_base_sensor at the time of the message, since a gimbal turns. Where tf does not know that
/// time, the newest transform counts.
/// @param origin named in errors. @throws InputError when tf does not know the frames
Pose sensorMounting(const tf2::BufferCore& transforms, const std::string& base_frame,
                    const std_msgs::Header& header, const std::string& origin);

/// T_moment_stamp of the base by odometry: how the robot moved from one time to the other. Identity
/// when the times are the same, more than a second apart, or not both known to odometry.
Pose baseMotion(const tf2::BufferCore& odometry, const std::string& odom_frame,
                const std::string& base_frame, const ros::Time& moment, const ros::Time& stamp);

}  // namespace edge_mcl
