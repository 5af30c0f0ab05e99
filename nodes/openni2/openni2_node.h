/// Publishes a depth camera.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameter_range.h"
#include "edge_mcl/nodes/common/wall_pace.h"
#include "edge_mcl/nodes/openni2/device_clock.h"
#include "edge_mcl/nodes/openni2/openni2_camera.h"

namespace edge_mcl {

/// Parameters of the node. The functions of parameter_struct.h work with them.
struct OpenNi2Parameters : DepthCameraOptions {
  std::string color_frame_id = "camera_color_optical_frame";
  std::string depth_frame_id = "camera_depth_optical_frame";
  std::string color_calibration, depth_calibration;
  double retry_period = 1;
  bool loop = false;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("device", device, "", anyValue(),
      "URI, serial number or .oni file; empty: the first device that is found");
    v("color", color, "", anyValue(), "colour images are published");
    v("depth", depth, "", anyValue(), "depth images are published");
    v("color_width", color_width, "px", atLeast(1), "width of the colour image");
    v("color_height", color_height, "px", atLeast(1), "height of the colour image");
    v("color_fps", color_fps, "Hz", atLeast(1), "rate of the colour images");
    v("depth_width", depth_width, "px", atLeast(1), "width of the depth image");
    v("depth_height", depth_height, "px", atLeast(1), "height of the depth image");
    v("depth_fps", depth_fps, "Hz", atLeast(1), "rate of the depth images");
    v("registration", registration, "", anyValue(),
      "depth is registered to the colour image when the device supports this");
    v("mirror", mirror, "", anyValue(), "images are mirrored");
    v("color_frame_id", color_frame_id, "", anyValue(), "frame of the colour camera");
    v("depth_frame_id", depth_frame_id, "", anyValue(), "frame of depth that is not registered");
    v("color_calibration", color_calibration, "", anyValue(),
      "YAML file of camera_calibration; empty: the field of view that the device reports");
    v("depth_calibration", depth_calibration, "", anyValue(),
      "YAML file of camera_calibration; empty: the field of view that the device reports");
    v("retry_period", retry_period, "s", positive(), "time between attempts to open the device");
    v("loop", loop, "", anyValue(), "a recording is played again when it ends");
  }
  /// Faults that the ranges do not cover, one text each.
  std::vector<std::string> faults() const;
};

/// The node of a depth camera.
class OpenNi2Node {
 public:
  /// @throws ParameterError for a wrong parameter; InputError when a calibration cannot be read
  OpenNi2Node(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);
  /// Publishes until ROS shuts down or a recording ends. Waits for a device that is missing.
  /// @throws InputError when a recording cannot be read
  void run();

 private:
  struct Stream {
    image_transport::CameraPublisher publisher;
    sensor_msgs::CameraInfo info;
    ros::Time last_stamp;
  };
  bool open();
  void prepareStreams();
  void publish(const OpenNi2Camera::Frame& frame);
  void wait(double seconds);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  OpenNi2Parameters params_;
  image_transport::ImageTransport transport_;
  diagnostic_updater::Updater diagnostics_;
  WallPace diagnostics_pace_;
  std::unique_ptr<OpenNi2Camera> camera_;
  Stream color_, depth_;
  DeviceClock clock_;  // one for both streams, so that frames of one moment have one stamp
  std::string description_, problem_;
  uint64_t frames_ = 0, frames_before_ = 0;
  ros::WallTime diagnosed_at_ = ros::WallTime::now();
};

}  // namespace edge_mcl
