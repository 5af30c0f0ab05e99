/// Reads a depth camera through OpenNI2. This unit does not use ROS.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// Settings of a depth camera. Sizes are in pixels, rates in Hz.
struct DepthCameraOptions {
  std::string device;  ///< URI, serial number or .oni file; empty: the first device found
  bool color = true, depth = true;
  int color_width = 640, color_height = 480, color_fps = 30;
  int depth_width = 640, depth_height = 480, depth_fps = 30;
  bool registration = true;  ///< depth in the pixels of the colour camera, if supported
  bool mirror = false;
};

/// A depth camera or a recording of one.
class OpenNi2Camera {
 public:
  /// Opens the device and starts its streams. A recording has the modes with which it was made.
  /// @throws InputError when there is no such device or mode (it names those that exist); Error
  /// when OpenNI2 itself does not work
  explicit OpenNi2Camera(const DepthCameraOptions& options);
  ~OpenNi2Camera();
  OpenNi2Camera(const OpenNi2Camera&) = delete;
  OpenNi2Camera& operator=(const OpenNi2Camera&) = delete;

  struct Frame {
    bool is_depth = false;
    cv::Mat pixels;          ///< CV_8UC3 (red, green, blue) or CV_8U; depth: CV_16U, mm
    double device_time = 0;  ///< time of the device's clock, s
  };
  enum class Event { kFrame, kNothing, kLost, kEnd };
  /// Waits for a frame. @return kFrame: `frame` is set; kNothing: no frame came within the timeout;
  /// kLost: the device was unplugged; kEnd: the recording is over. After kLost and kEnd the object
  /// can only be destroyed.
  Event read(Frame* frame, int timeout_ms);

  bool hasColor() const;
  bool hasDepth() const;
  bool isRegistered() const;
  /// Camera models of both streams, without distortion. They follow from the fields of view,
  /// because the device reports nothing else about its lenses. @throws Error without such a stream
  CameraModel colorModel() const;
  CameraModel depthModel() const;
  /// Name, URI and modes, as a text for the user.
  std::string description() const;

  /// URI and name of every device that is connected now.
  static std::vector<std::string> devices();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
