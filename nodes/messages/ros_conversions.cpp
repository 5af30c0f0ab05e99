#include "edge_mcl/nodes/messages/ros_conversions.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/distortion_models.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

template <class Quaternion>
void setQuaternion(const Pose& pose, Quaternion* q) {
  const Eigen::Quaterniond rotation(pose.linear());
  q->x = rotation.x();
  q->y = rotation.y();
  q->z = rotation.z();
  q->w = rotation.w();
}

Pose poseOf(double x, double y, double z, const geometry_msgs::Quaternion& q,
            const std::string& origin) {
  const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
  if (!std::isfinite(x + y + z) || !rotation.coeffs().allFinite())
    throw InputError(origin + ": the pose is not finite");
  if (std::abs(rotation.norm() - 1) > 0.01)
    throw InputError(origin + ": the quaternion does not have unit length");
  Pose pose = Pose::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

/// Checks the size of an image. @throws InputError when the encoding is unknown or the message has
/// too few bytes
void checkSize(const sensor_msgs::Image& message, const std::string& origin) {
  size_t pixel_bytes = 0;
  try {
    pixel_bytes = sensor_msgs::image_encodings::numChannels(message.encoding) *
                  static_cast<size_t>(sensor_msgs::image_encodings::bitDepth(message.encoding)) / 8;
  } catch (const std::exception&) {
    throw InputError(origin + ": unknown encoding '" + message.encoding + "'");
  }
  if (message.width == 0 || message.height == 0 || message.step < pixel_bytes * message.width ||
      message.data.size() < static_cast<size_t>(message.step) * message.height)
    throw InputError(origin + ": truncated image: " + std::to_string(message.data.size()) +
                     " bytes for " + std::to_string(message.width) + "x" +
                     std::to_string(message.height) + " " + message.encoding);
}

}  // namespace

geometry_msgs::Pose toPoseMessage(const Pose& pose) {
  geometry_msgs::Pose message;
  message.position.x = pose.translation().x();
  message.position.y = pose.translation().y();
  message.position.z = pose.translation().z();
  setQuaternion(pose, &message.orientation);
  return message;
}

geometry_msgs::Transform toTransformMessage(const Pose& pose) {
  geometry_msgs::Transform message;
  message.translation.x = pose.translation().x();
  message.translation.y = pose.translation().y();
  message.translation.z = pose.translation().z();
  setQuaternion(pose, &message.rotation);
  return message;
}

geometry_msgs::TransformStamped toTransformStamped(const Pose& pose, const ros::Time& stamp,
                                                   const std::string& parent,
                                                   const std::string& child) {
  geometry_msgs::TransformStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform = toTransformMessage(pose);
  return message;
}

geometry_msgs::PoseWithCovariance toPoseMessage(const PoseGaussian& gaussian) {
  geometry_msgs::PoseWithCovariance message;
  message.pose = toPoseMessage(gaussian.mean);
  const Matrix6 covariance = covarianceInMapAxes(gaussian);
  std::copy(covariance.data(), covariance.data() + 36, message.covariance.begin());
  return message;
}

Pose fromMessage(const geometry_msgs::Pose& m, const std::string& origin) {
  return poseOf(m.position.x, m.position.y, m.position.z, m.orientation, origin);
}

Pose fromMessage(const geometry_msgs::Transform& m, const std::string& origin) {
  return poseOf(m.translation.x, m.translation.y, m.translation.z, m.rotation, origin);
}

PoseGaussian fromMessage(const geometry_msgs::PoseWithCovariance& message,
                         const std::string& origin) {
  PoseGaussian gaussian;
  gaussian.mean = fromMessage(message.pose, origin);
  const Matrix6 covariance = Eigen::Map<const Matrix6>(message.covariance.data());
  if (!covariance.allFinite()) throw InputError(origin + ": the covariance is not finite");
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() >
          1e-6 * std::max(1.0, covariance.cwiseAbs().maxCoeff()) ||
      covariance.diagonal().minCoeff() < 0)
    throw InputError(origin + ": the covariance is not symmetric with variances of zero or more");
  gaussian.covariance = covarianceFromMapAxes(gaussian.mean, covariance);
  return gaussian;
}

CameraModel fromMessage(const sensor_msgs::CameraInfo& message, const std::string& origin) {
  std::array<double, 9> k{};
  std::copy(message.K.begin(), message.K.end(), k.begin());
  return CameraModel::fromFields(static_cast<int>(message.width), static_cast<int>(message.height),
                                 k, message.distortion_model, message.D.data(), message.D.size(),
                                 origin);
}

sensor_msgs::CameraInfo toCameraInfo(const CameraModel& camera, const ros::Time& stamp,
                                     const std::string& frame) {
  sensor_msgs::CameraInfo message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.width = static_cast<uint32_t>(camera.width);
  message.height = static_cast<uint32_t>(camera.height);
  message.K = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  message.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  message.P = {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0};
  const bool fisheye = camera.distortion == DistortionModel::kEquidistant;
  const bool rational = camera.distortion == DistortionModel::kRationalPolynomial;
  message.distortion_model = fisheye    ? sensor_msgs::distortion_models::EQUIDISTANT
                             : rational ? sensor_msgs::distortion_models::RATIONAL_POLYNOMIAL
                                        : sensor_msgs::distortion_models::PLUMB_BOB;
  message.D.assign(camera.coefficients.begin(), camera.coefficients.begin() + (fisheye    ? 4
                                                                               : rational ? 8
                                                                                          : 5));
  return message;
}

sensor_msgs::ImagePtr toImage(const cv::Mat& image, const std::string& encoding,
                              const ros::Time& stamp, const std::string& frame) {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = frame;
  return cv_bridge::CvImage(header, encoding, image).toImageMsg();
}

cv::Mat fromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin) {
  namespace encodings = sensor_msgs::image_encodings;
  checkSize(*message, origin);
  try {
    if (message->encoding == encodings::MONO8 || message->encoding == encodings::BGR8 ||
        message->encoding == encodings::MONO16)
      return cv_bridge::toCvShare(message)->image;
    const bool grey = encodings::isMono(message->encoding);
    return cv_bridge::toCvShare(message, grey ? encodings::MONO8 : encodings::BGR8)->image;
  } catch (const std::exception& e) {
    throw InputError(origin + ": encoding '" + message->encoding +
                     "' cannot be used: " + std::string(e.what()));
  }
}

cv::Mat depthFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin) {
  namespace encodings = sensor_msgs::image_encodings;
  checkSize(*message, origin);
  const bool metres = message->encoding == encodings::TYPE_32FC1;
  if (!metres && message->encoding != encodings::TYPE_16UC1 &&
      message->encoding != encodings::MONO16)
    throw InputError(origin + ": a depth image must be 16UC1 or 32FC1, not '" + message->encoding +
                     "'");
  if (message->is_bigendian) throw InputError(origin + ": a big-endian depth image cannot be used");
  return {static_cast<int>(message->height), static_cast<int>(message->width),
          metres ? CV_32FC1 : CV_16UC1, const_cast<uint8_t*>(message->data.data()), message->step};
}

cv::Mat maskFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin) {
  checkSize(*message, origin);
  if (sensor_msgs::image_encodings::numChannels(message->encoding) != 1 ||
      sensor_msgs::image_encodings::bitDepth(message->encoding) != 8)
    throw InputError(origin + ": a mask must be mono8, not '" + message->encoding + "'");
  return {static_cast<int>(message->height), static_cast<int>(message->width), CV_8UC1,
          const_cast<uint8_t*>(message->data.data()), message->step};
}

sensor_msgs::Imu toImu(const ImuReading& reading, const ros::Time& stamp,
                       const std::string& frame) {
  sensor_msgs::Imu message;
  message.header.stamp = stamp;
  message.header.frame_id = frame;
  message.orientation_covariance[0] = -1;  // no orientation
  message.angular_velocity.x = reading.angular_velocity.x();
  message.angular_velocity.y = reading.angular_velocity.y();
  message.angular_velocity.z = reading.angular_velocity.z();
  message.linear_acceleration.x = reading.specific_force.x();
  message.linear_acceleration.y = reading.specific_force.y();
  message.linear_acceleration.z = reading.specific_force.z();
  return message;
}

}  // namespace edge_mcl
