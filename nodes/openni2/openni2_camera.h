/// A depth camera through OpenNI2. No ROS in here.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

struct DepthCameraOptions {
  std::string device;  ///< URI, serial number or .oni file; empty: the first that is found
  bool color = true, depth = true;
  int color_width = 640, color_height = 480, color_fps = 30;
  int depth_width = 640, depth_height = 480, depth_fps = 30;
  bool registration = true;  ///< depth in the colour camera's pixels, where the device can
  bool mirror = false;
};

class OpenNi2Camera {
 public:
  /// Opens the device and starts its streams; recordings have the modes they were made with.
  /// @throws InputError when there is no such device or mode (naming those that are there), Error
  /// when OpenNI2 itself does not work.
  explicit OpenNi2Camera(const DepthCameraOptions& options);
  ~OpenNi2Camera();
  OpenNi2Camera(const OpenNi2Camera&) = delete;
  OpenNi2Camera& operator=(const OpenNi2Camera&) = delete;

  struct Frame {
    bool is_depth = false;
    cv::Mat pixels;          ///< CV_8UC3 (red, green, blue) or CV_8U; depth: CV_16U, millimetres
    double device_time = 0;  ///< seconds of the device's clock
  };
  enum class Event { kFrame, kNothing, kLost, kEnd };
  /// Waits for a frame. kLost: unplugged; kEnd: of a recording. After both only destruction is
  /// left.
  Event read(Frame* frame, int timeout_ms);

  bool hasColor() const;
  bool hasDepth() const;
  bool isRegistered() const;
  /// From the fields of view, which is what the device knows of its lenses.
  CameraModel colorModel() const;
  CameraModel depthModel() const;
  /// Name, URI and modes, for people.
  std::string description() const;

  /// URI and name of every device that is there now.
  static std::vector<std::string> devices();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
