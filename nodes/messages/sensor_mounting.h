/// Where a sensor is mounted on the robot, by tf.
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

}  // namespace edge_mcl
