#include "edge_mcl/nodes/messages/sensor_mounting.h"

#include <cmath>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

Pose sensorMounting(const tf2::BufferCore& transforms, const std::string& base_frame,
                    const std_msgs::Header& header, const std::string& origin) {
  const std::string frame = frameName(header.frame_id);
  if (frame == base_frame) return Pose::Identity();
  ros::Time at = header.stamp;
  std::string why;
  if (!transforms.canTransform(base_frame, frame, at)) at = ros::Time(0);
  if (!transforms.canTransform(base_frame, frame, at, &why))
    throw InputError(origin + ": where is it on the robot? " + why);
  return fromMessage(transforms.lookupTransform(base_frame, frame, at).transform, origin);
}

namespace {

/// The only frame that is named as an optical one; empty: there is none or more than one.
std::string onlyOpticalFrame(const tf2::BufferCore& transforms) {
  std::vector<std::string> frames;
  transforms._getFrameStrings(frames);
  std::string found;
  for (const std::string& frame : frames) {
    if (frame.find("optical") == std::string::npos) continue;
    if (!found.empty()) return "";
    found = frame;
  }
  return found;
}

/// Frames of the same name in a namespace, for messages.
std::string namesakes(const tf2::BufferCore& transforms, const std::string& frame) {
  std::vector<std::string> frames;
  transforms._getFrameStrings(frames);
  std::string text;
  const std::string end = "/" + frame;
  for (const std::string& other : frames)
    if (other.size() > end.size() && other.compare(other.size() - end.size(), end.size(), end) == 0)
      text += (text.empty() ? " (but '" : ", '") + other + "'";
  return text.empty() ? text : text + ")";
}

}  // namespace

CameraMounting::CameraMounting(const std::string& base_frame, double patience)
    : base_frame_(frameName(base_frame)), patience_(patience) {}

void CameraMounting::becomeBase(const std::string& why) {
  is_base_ = true;
  notes_.push_back(why +
                   ", so the poses are those of the camera itself (x right, y down, z ahead), and "
                   "odometry is not used");
}

Pose CameraMounting::of(const tf2::BufferCore& transforms, const std_msgs::Header& header,
                        const std::string& frame, const std::string& origin) {
  std_msgs::Header named = header;
  named.frame_id = frame.empty() ? frameName(header.frame_id) : frame;
  if (is_base_ || named.frame_id == base_frame_) return Pose::Identity();
  if (named.frame_id.empty()) {
    if (frame_of_nameless_.empty()) frame_of_nameless_ = onlyOpticalFrame(transforms);
    named.frame_id = frame_of_nameless_;
    if (!named.frame_id.empty() && !is_guess_told_)
      notes_.push_back("the images name no frame; '" + named.frame_id +
                       "' is taken, the only optical frame in tf (camera_frame_id, or --topics "
                       "camera_frame=, names another)");
    is_guess_told_ = true;
  }
  if (named.frame_id.empty()) {
    becomeBase(
        "the images name no frame, and none is given (camera_frame_id, or --topics camera_frame=)");
    return Pose::Identity();
  }
  if (!asked_) asked_ = ros::WallTime::now();
  if (!transforms._frameExists(base_frame_) && ros::WallTime::now() - *asked_ >= patience_) {
    becomeBase("tf does not know '" + base_frame_ + "'" + namesakes(transforms, base_frame_));
    return Pose::Identity();
  }
  Pose T_base_camera = sensorMounting(transforms, base_frame_, named, origin);
  if (hasBodyAxes(T_base_camera) && !is_axis_told_) {
    is_axis_told_ = true;
    notes_.push_back(
        "frame '" + named.frame_id +
        "' seems to have x ahead and z up, but a camera needs an optical frame (z "
        "ahead, y down); publish one, e.g. static_transform_publisher 0 0 0 -0.5 0.5 "
        "-0.5 0.5 " +
        named.frame_id + " " + named.frame_id +
        "_in_image_axes, and name it as the camera's frame (camera_frame_id, or --topics "
        "camera_frame=)");
  }
  return T_base_camera;
}

std::vector<std::string> CameraMounting::takeNotes() { return std::exchange(notes_, {}); }

bool hasBodyAxes(const Pose& T_base_camera) {
  // The frame of a body that is pitched by up to 45 degrees and turned by as much. The optical axis
  // of such a frame would look up, and its image would be upright to nobody.
  constexpr double kAlong = 0.7;
  const Eigen::Matrix3d& axes = T_base_camera.linear();
  return axes(2, 2) > kAlong && axes(1, 1) > kAlong;
}

Pose baseMotion(const tf2::BufferCore& odometry, const std::string& odom_frame,
                const std::string& base_frame, const ros::Time& moment, const ros::Time& stamp) {
  constexpr double kLongest = 1;  // s; messages of one moment are hardly farther apart
  if (stamp == moment || std::abs((stamp - moment).toSec()) > kLongest) return Pose::Identity();
  // A rig that stands without odometry is no fault, so this asks first.
  if (!odometry.canTransform(base_frame, moment, base_frame, stamp, odom_frame))
    return Pose::Identity();
  return fromMessage(
      odometry.lookupTransform(base_frame, moment, base_frame, stamp, odom_frame).transform,
      "odometry");
}

}  // namespace edge_mcl
