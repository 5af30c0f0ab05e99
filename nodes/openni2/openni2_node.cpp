#include "edge_mcl/nodes/openni2/openni2_node.h"

#include <ros/console.h>
#include <ros/init.h>
#include <ros/this_node.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/nodes/common/private_parameters.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

std::vector<std::string> OpenNi2Parameters::faults() const {
  std::vector<std::string> list;
  if (!color && !depth) list.emplace_back("~color and ~depth must not both be false");
  if (color_frame_id.empty() || depth_frame_id.empty())
    list.emplace_back("~color_frame_id and ~depth_frame_id must have names");
  return list;
}

OpenNi2Node::OpenNi2Node(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh)
    : params_(readParameterStruct<OpenNi2Parameters>(private_nh)),
      transport_(nh),
      diagnostics_(nh, private_nh) {
  // Faults of the calibration files are reported at the start, not only when a device is plugged
  // in.
  for (const std::string& file : {params_.color_calibration, params_.depth_calibration})
    if (!file.empty()) CameraModel::fromYamlFile(file);
  if (params_.color) color_.publisher = transport_.advertiseCamera("color/image_raw", 2);
  if (params_.depth) depth_.publisher = transport_.advertiseCamera("depth/image_raw", 2);
  diagnostics_.setHardwareID("OpenNI2");
  diagnostics_.add("depth camera", this, &OpenNi2Node::diagnose);
}

void OpenNi2Node::prepareStreams() {
  const auto infoOf = [](const std::string& calibration, const CameraModel& of_device,
                         const std::string& frame) {
    if (calibration.empty()) return toCameraInfo(of_device, ros::Time(), frame);
    const CameraModel model = CameraModel::fromYamlFile(calibration);
    if (model.width != of_device.width || model.height != of_device.height)
      throw InputError(calibration + ": the calibration is for " + std::to_string(model.width) +
                       "x" + std::to_string(model.height) + " pixels, the stream has " +
                       std::to_string(of_device.width) + "x" + std::to_string(of_device.height));
    return toCameraInfo(model, ros::Time(), frame);
  };
  if (camera_->hasColor())
    color_.info = infoOf(params_.color_calibration, camera_->colorModel(), params_.color_frame_id);
  if (!camera_->hasDepth()) return;
  // Registered depth has the pixels of the colour camera. So it has the frame of the colour camera,
  // and also its calibration when both images have the same size.
  const bool as_color = camera_->isRegistered() && camera_->hasColor();
  const CameraModel model = camera_->depthModel();
  const bool same_size = as_color && model.width == static_cast<int>(color_.info.width) &&
                         model.height == static_cast<int>(color_.info.height);
  if (same_size && params_.depth_calibration.empty())
    depth_.info = color_.info;
  else
    depth_.info =
        infoOf(params_.depth_calibration, as_color && same_size ? camera_->colorModel() : model,
               as_color ? params_.color_frame_id : params_.depth_frame_id);
}

bool OpenNi2Node::open() {
  const bool recording =
      params_.device.size() > 4 && params_.device.substr(params_.device.size() - 4) == ".oni";
  try {
    camera_ = std::make_unique<OpenNi2Camera>(params_);
    prepareStreams();
    description_ = camera_->description();
    problem_.clear();
    ROS_INFO("%s", description_.c_str());
    return true;
  } catch (const InputError& e) {
    camera_.reset();
    // A missing file does not appear by waiting.
    if (recording) throw;
    problem_ = e.what();
    ROS_WARN_THROTTLE(10, "%s; waiting for a device", e.what());
    return false;
  }
}

void OpenNi2Node::publish(const OpenNi2Camera::Frame& frame) {
  Stream& stream = frame.is_depth ? depth_ : color_;
  const double now = ros::Time::now().toSec();
  const ros::Time stamp(std::max(0.0, clock_.toHost(frame.device_time, now)));
  // Until the smallest delay is known, the stamp of a frame may lie before the stamp of the last
  // one. Such a frame is dropped.
  if (stamp <= stream.last_stamp && stream.last_stamp - stamp < ros::Duration(1)) return;
  stream.last_stamp = stamp;
  ++frames_;
  if (stream.publisher.getNumSubscribers() == 0) return;
  const char* encoding = frame.is_depth                   ? "16UC1"
                         : frame.pixels.type() == CV_8UC3 ? "rgb8"
                                                          : "mono8";
  auto info = boost::make_shared<sensor_msgs::CameraInfo>(stream.info);
  info->header.stamp = stamp;
  stream.publisher.publish(toImage(frame.pixels, encoding, stamp, info->header.frame_id), info);
}

void OpenNi2Node::wait(double seconds) {
  const ros::WallTime until = ros::WallTime::now() + ros::WallDuration(seconds);
  while (ros::ok() && ros::WallTime::now() < until) {
    ros::spinOnce();
    if (diagnostics_pace_.isDue(diagnostics_.getPeriod())) diagnostics_.force_update();
    ros::WallDuration(0.02).sleep();
  }
}

void OpenNi2Node::run() {
  constexpr int kTimeout = 100;  // ms
  while (ros::ok()) {
    if (!camera_ && !open()) {
      wait(params_.retry_period);
      continue;
    }
    OpenNi2Camera::Frame frame;
    switch (camera_->read(&frame, kTimeout)) {
      case OpenNi2Camera::Event::kFrame:
        publish(frame);
        break;
      case OpenNi2Camera::Event::kNothing:
        break;
      case OpenNi2Camera::Event::kLost:
        problem_ = description_ + ": unplugged";
        ROS_WARN("%s; waiting for the device", problem_.c_str());
        camera_.reset();
        break;
      case OpenNi2Camera::Event::kEnd:
        camera_.reset();
        if (!params_.loop) {
          ROS_INFO("%s: the recording is over", params_.device.c_str());
          return;
        }
        break;
    }
    ros::spinOnce();
    if (diagnostics_pace_.isDue(diagnostics_.getPeriod())) diagnostics_.force_update();
  }
}

void OpenNi2Node::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using Level = diagnostic_msgs::DiagnosticStatus;
  const ros::WallTime now = ros::WallTime::now();
  const double seconds = (now - diagnosed_at_).toSec();
  const double rate = seconds > 0 ? static_cast<double>(frames_ - frames_before_) / seconds : 0;
  diagnosed_at_ = now;
  frames_before_ = frames_;
  if (!camera_)
    status.summary(Level::ERROR, problem_.empty() ? "no device yet" : problem_);
  else if (rate == 0)
    status.summary(Level::WARN, "no frames");
  else
    status.summary(Level::OK, "streaming");
  status.add("device", description_);
  status.add("frames per second, all streams", rate);
}

}  // namespace edge_mcl
