#include "edge_mcl/nodes/messages/ros_conversions.h"

#include <sensor_msgs/distortion_models.h>

#include <algorithm>
#include <cmath>
#include <regex>
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
  if (!isOnEarth({x, y, z}))
    throw InputError(origin + ": the position is farther away than any place on earth");
  Pose pose = Pose::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
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

namespace {

/// The camera of the pixels that the driver sends: a part of the full image, with pixels joined.
CameraModel partOf(CameraModel camera, const sensor_msgs::CameraInfo& message,
                   const std::string& origin) {
  const sensor_msgs::RegionOfInterest& roi = message.roi;
  const uint32_t binning_x = std::max(1U, message.binning_x);
  const uint32_t binning_y = std::max(1U, message.binning_y);
  const bool is_full = roi.width == 0 && roi.height == 0 && roi.x_offset == 0 && roi.y_offset == 0;
  if (is_full && binning_x == 1 && binning_y == 1) return camera;
  if (!is_full) {
    // Some drivers set only the offsets.
    const uint32_t width = roi.width > 0 ? roi.width : message.width - roi.x_offset;
    const uint32_t height = roi.height > 0 ? roi.height : message.height - roi.y_offset;
    if (roi.x_offset + width > message.width || roi.y_offset + height > message.height)
      throw InputError(origin + ": the region of interest is outside the image");
    camera.cx -= roi.x_offset;
    camera.cy -= roi.y_offset;
    camera.width = static_cast<int>(width);
    camera.height = static_cast<int>(height);
  }
  camera.fx /= binning_x;
  camera.cx /= binning_x;
  camera.width /= static_cast<int>(binning_x);
  camera.fy /= binning_y;
  camera.cy /= binning_y;
  camera.height /= static_cast<int>(binning_y);
  camera.validate(origin);
  return camera;
}

}  // namespace

CameraModel fromMessage(const sensor_msgs::CameraInfo& message, const std::string& origin,
                        bool rectified) {
  const int width = static_cast<int>(message.width), height = static_cast<int>(message.height);
  std::array<double, 9> k{};
  std::copy(message.K.begin(), message.K.end(), k.begin());
  const auto& p = message.P;
  const bool has_p = p[0] != 0;
  const bool is_straight =
      std::all_of(message.D.begin(), message.D.end(), [](double d) { return d == 0; });
  // Without distortion K is as good, and some drivers leave P at zero.
  if (!rectified || (!has_p && is_straight))
    return partOf(CameraModel::fromFields(width, height, k, message.distortion_model,
                                          message.D.data(), message.D.size(), origin),
                  message, origin);
  if (!has_p)
    throw InputError(origin +
                     ": the images are rectified, but the matrix P of their calibration is "
                     "zero; calibrate the camera, or use the images before rectification");
  k = {p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]};
  return partOf(CameraModel::fromFields(width, height, k, "none", nullptr, 0, origin), message,
                origin);
}

bool isRectifiedTopic(const std::string& topic) {
  static const std::regex kRectified("(^|[/_])rect(ified)?($|[/_])");
  return std::regex_search(topic, kRectified);
}

std::string frameName(const std::string& frame) {
  return !frame.empty() && frame.front() == '/' ? frame.substr(1) : frame;
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
