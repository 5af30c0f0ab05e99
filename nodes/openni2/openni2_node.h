/// A depth camera, published.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "edge_mcl/nodes/common/wall_pace.h"
#include "edge_mcl/nodes/openni2/device_clock.h"
#include "edge_mcl/nodes/openni2/openni2_camera.h"

namespace edge_mcl {

struct OpenNi2Parameters : DepthCameraOptions {
  std::string color_frame_id = "camera_color_optical_frame";
  std::string depth_frame_id = "camera_depth_optical_frame";  ///< of unregistered depth
  std::string color_calibration, depth_calibration;           ///< YAML of camera_calibration
  double retry_period = 1;                                    ///< s
  bool loop = false;                                          ///< play a recording again and again

  template <class Visitor>
  void visit(Visitor&& v) {
    v("device", device);
    v("color", color);
    v("depth", depth);
    v("color_width", color_width);
    v("color_height", color_height);
    v("color_fps", color_fps);
    v("depth_width", depth_width);
    v("depth_height", depth_height);
    v("depth_fps", depth_fps);
    v("registration", registration);
    v("mirror", mirror);
    v("color_frame_id", color_frame_id);
    v("depth_frame_id", depth_frame_id);
    v("color_calibration", color_calibration);
    v("depth_calibration", depth_calibration);
    v("retry_period", retry_period);
    v("loop", loop);
  }
  std::vector<std::string> faults() const;
};

class OpenNi2Node {
 public:
  /// @throws ParameterError; InputError when a calibration or a recording cannot be read.
  OpenNi2Node(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);
  /// Publishes until ROS ends, or a recording does. A device that is missing is waited for.
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
  DeviceClock clock_;  // one for both: frames of one moment keep one time
  std::string description_, problem_;
  uint64_t frames_ = 0, frames_before_ = 0;
  ros::WallTime diagnosed_at_ = ros::WallTime::now();
};

}  // namespace edge_mcl
