#include "edge_mcl/nodes/messages/recording_messages.h"

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

RecordingMessages::RecordingMessages(RecordingSetup setup, RecordingFrames frames)
    : setup_(std::move(setup)), frames_(std::move(frames)) {}

sensor_msgs::ImagePtr RecordingMessages::image(const cv::Mat& color, const ros::Time& stamp) const {
  switch (color.type()) {
    case CV_8UC1:
      return toImage(color, "mono8", stamp, frames_.camera);
    case CV_8UC3:
      return toImage(color, "bgr8", stamp, frames_.camera);
    case CV_8UC4:
      return toImage(color, "bgra8", stamp, frames_.camera);
    case CV_16UC1:
      return toImage(color, "mono16", stamp, frames_.camera);
    case CV_16UC3:
      return toImage(color, "bgr16", stamp, frames_.camera);
    case CV_16UC4:
      return toImage(color, "bgra16", stamp, frames_.camera);
    default:
      throw InputError("the image has a type for which ROS has no encoding");
  }
}

sensor_msgs::CameraInfo RecordingMessages::info(const ros::Time& stamp) const {
  return toCameraInfo(setup_.camera, stamp, frames_.camera);
}

sensor_msgs::ImagePtr RecordingMessages::depth(const cv::Mat& depth, const ros::Time& stamp) const {
  cv::Mat metres;
  depth.convertTo(metres, CV_32F, 1 / setup_.depth_scale);
  return toImage(metres, "32FC1", stamp, frames_.camera);
}

sensor_msgs::ImagePtr RecordingMessages::mask(const cv::Mat& mask, const ros::Time& stamp) const {
  return toImage(mask, "mono8", stamp, frames_.camera);
}

geometry_msgs::PoseStamped RecordingMessages::truth(const Pose& T_map_camera,
                                                    const ros::Time& stamp) const {
  geometry_msgs::PoseStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = frames_.map;
  message.pose = toPoseMessage(T_map_camera * setup_.T_base_camera.inverse());
  return message;
}

Pose RecordingMessages::baseInOdometry(const Pose& T_odom_camera) const {
  return setup_.T_base_camera * T_odom_camera * setup_.T_base_camera.inverse();
}

nav_msgs::Odometry RecordingMessages::odometry(const Pose& T_odom_camera,
                                               const ros::Time& stamp) const {
  nav_msgs::Odometry message;
  message.header.stamp = stamp;
  message.header.frame_id = frames_.odom;
  message.child_frame_id = frames_.base;
  message.pose.pose = toPoseMessage(baseInOdometry(T_odom_camera));
  return message;
}

tf2_msgs::TFMessage RecordingMessages::odometryTransform(const Pose& T_odom_camera,
                                                         const ros::Time& stamp) const {
  tf2_msgs::TFMessage message;
  message.transforms.push_back(
      toTransformStamped(baseInOdometry(T_odom_camera), stamp, frames_.odom, frames_.base));
  return message;
}

tf2_msgs::TFMessage RecordingMessages::mounting(const ros::Time& stamp) const {
  tf2_msgs::TFMessage message;
  message.transforms.push_back(
      toTransformStamped(setup_.T_base_camera, stamp, frames_.base, frames_.camera));
  return message;
}

geometry_msgs::PoseWithCovarianceStamped RecordingMessages::initialPose(
    const ros::Time& stamp) const {
  const auto square = [](double v) { return v * v; };
  PoseGaussian of_camera;
  of_camera.mean = setup_.initial_pose;
  of_camera.covariance.diagonal().head<3>().setConstant(square(setup_.initial_std_position));
  of_camera.covariance.diagonal().tail<3>().setConstant(square(setup_.initial_std_angle));
  const Pose T_camera_base = setup_.T_base_camera.inverse();
  const Matrix6 to_base = adjoint(setup_.T_base_camera);
  PoseGaussian of_base;
  of_base.mean = of_camera.mean * T_camera_base;
  of_base.covariance = to_base * of_camera.covariance * to_base.transpose();
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = frames_.map;
  message.pose = toPoseMessage(of_base);
  return message;
}

}  // namespace edge_mcl
