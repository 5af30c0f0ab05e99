#include "edge_mcl/nodes/localizer/moment_reader.h"

#include <ros/console.h>

#include <cmath>

#include "edge_mcl/core/base/clock_step.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/mask_motion.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"
#include "edge_mcl/nodes/messages/sensor_mounting.h"

namespace edge_mcl {

namespace {

/// tf must know the base so long after the first image, s. Nodes of one launch file start within
/// some seconds.
constexpr double kTfPatience = 3;

}  // namespace

MomentReader::MomentReader(const ros::NodeHandle& nh, const NodeParameters& params, Cues cues,
                           size_t camera_count)
    : params_(params),
      cues_(cues),
      tf_listener_(tf_),
      mounting_(params.base_frame_id, kTfPatience),
      last_masks_(camera_count) {
  if (params_.odometry == "topic") odometry_buffer_ = std::make_unique<tf2::BufferCore>();
  if (params_.use_imu) {
    ros::NodeHandle handle(nh);
    imu_subscriber_ = handle.subscribe("imu", 100, &ImuHistory::add, &imu_);
  }
}

void MomentReader::addOdometry(const nav_msgs::Odometry& odometry) {
  if (!odometry_buffer_) return;
  const Pose pose = fromMessage(odometry.pose.pose, "odometry");
  const ros::Time& stamp = odometry.header.stamp;
  // The buffer refuses data that are much older than its newest.
  if (clockStep(odometry_at_.toSec(), stamp.toSec()) == ClockStep::kJumpedBack)
    odometry_buffer_->clear();
  odometry_at_ = stamp;
  odometry_buffer_->setTransform(
      toTransformStamped(pose, stamp, params_.odom_frame_id, params_.base_frame_id), "odom");
}

std::optional<Pose> MomentReader::odometryAt(const ros::Time& stamp, const ros::Time& latest,
                                             std::string* problem) {
  if (params_.odometry == "none" || mounting_.isBase()) return std::nullopt;
  const tf2::BufferCore& buffer = odometryBuffer();
  const std::string &odom = params_.odom_frame_id, &base = params_.base_frame_id;
  const auto newest = [&] {
    return buffer.canTransform(odom, base, ros::Time(0))
               ? buffer.lookupTransform(odom, base, ros::Time(0)).header.stamp
               : ros::Time(0);
  };
  // The wall clock counts, since a simulated clock may stand still.
  const auto until = ros::WallTime::now() + ros::WallDuration(params_.transform_timeout);
  std::string why;
  const auto await = [&](const ros::Time& time, Patience* patience) {
    const auto look = [&] {
      Look<Pose> now;
      // The newest is read first: data that arrive in between are then seen by one of the two.
      const ros::Time at = newest();
      now.newest = at.toSec();
      now.may_come = at <= time;
      if (buffer.canTransform(odom, base, time, &why))
        now.found = fromMessage(buffer.lookupTransform(odom, base, time).transform, "odometry");
      return now;
    };
    return awaitData<Pose>(
        patience, look, [&] { return ros::WallTime::now() < until; },
        [] { ros::WallDuration(0.002).sleep(); }, [&] { return running_.load(); });
  };
  try {
    if (std::optional<Pose> found = await(stamp, &odometry_patience_)) {
      // The other sensors are brought to their own times where odometry knows them.
      if (latest > stamp) await(latest, &sensors_patience_);
      return found;
    }
  } catch (const tf2::TransformException& e) {
    why = e.what();  // the buffer was cleared in between: the clock jumped back
  }
  *problem = "no odometry for the image: " + why;
  return std::nullopt;
}

std::optional<UpReading> MomentReader::upAt(const ros::Time& stamp, std::string* problem) {
  if (!params_.use_imu) return std::nullopt;
  try {
    const ImuOrientation imu = imu_.at(stamp);
    const Eigen::Matrix3d R_base_imu =
        sensorMounting(tf_, params_.base_frame_id, imu.header, "imu").linear();
    return UpReading{R_base_imu * imu.R_world_imu.transpose() * Eigen::Vector3d::UnitZ(),
                     params_.imu_sigma};
  } catch (const std::exception& e) {
    *problem = e.what();
    return std::nullopt;
  }
}

Pose MomentReader::mountingOf(const std_msgs::Header& header, const std::string& frame,
                              const std::string& origin, const ros::Time& moment) {
  Pose T_base_sensor = mounting_.of(tf_, header, frame, origin);
  for (const std::string& note : mounting_.takeNotes())
    ROS_WARN("%s: %s", origin.c_str(), note.c_str());
  if (params_.odometry == "none" || mounting_.isBase()) return T_base_sensor;
  return baseMotion(odometryBuffer(), params_.odom_frame_id, params_.base_frame_id, moment,
                    header.stamp) *
         T_base_sensor;
}

cv::Mat MomentReader::maskFor(const Moment::CameraPart& part, const CameraModel& model,
                              const Pose& T_base_camera, LastMask* last,
                              MomentInput* result) const {
  const MaskMatcher::Match& match = *part.match;
  std::optional<Eigen::Matrix3d> R_odom_camera;
  if (result->input.odometry) R_odom_camera = (*result->input.odometry * T_base_camera).linear();
  if (match.mask) {
    cv::Mat mask = maskFromMessage(match.mask, part.origin + " mask");
    result->mask_age = 0;
    if (params_.mask_policy == "use_last")
      *last = {mask.clone(), match.image->header.stamp, R_odom_camera};
    return mask;
  }
  if (params_.mask_policy == "skip_update")
    throw InputError(part.origin + ": no mask in time, image not used");
  if (params_.mask_policy != "use_last" || last->mask.empty()) return {};
  result->mask_age = (match.image->header.stamp - last->stamp).toSec();
  if (result->mask_age < 0) return {};  // the clock was set back: the mask shows another time
  if (!R_odom_camera || !last->R_odom_camera) return last->mask;
  return turnMask(last->mask, model, R_odom_camera->transpose() * *last->R_odom_camera);
}

void MomentReader::addView(const Moment::CameraPart& part, const ros::Time& moment, LastMask* last,
                           MomentInput* result) {
  if (!part.match) throw InputError(part.origin + ": no image of this moment");
  if (!part.info) throw InputError(part.origin + ": no camera_info yet");
  const sensor_msgs::ImageConstPtr& image = part.match->image;
  LiveInput::CameraImage view;
  view.origin = part.origin;
  view.camera = fromMessage(*part.info, part.origin + " camera_info", part.is_rectified);
  view.image = fromMessage(image, part.origin);
  view.T_base_camera = mountingOf(image->header, part.frame, part.origin, moment);
  if (params_.use_masks) view.mask = maskFor(part, view.camera, view.T_base_camera, last, result);
  result->input.images.push_back(std::move(view));
}

void MomentReader::addDepth(const Moment::CameraPart& part, const ros::Time& moment, size_t camera,
                            LastMask* last, MomentInput* result) {
  const std::string origin = part.origin + " depth";
  if (!part.depth) throw InputError(origin + ": no depth image in time");
  // Depth that is registered to the colour camera may have no calibration of its own.
  const sensor_msgs::CameraInfoConstPtr& info = part.depth_info ? part.depth_info : part.info;
  if (!info) throw InputError(origin + ": no camera_info yet");
  LiveInput::Depth depth;
  depth.image.origin = origin;
  depth.image.camera = fromMessage(*info, origin + " camera_info",
                                   part.depth_info ? part.is_depth_rectified : part.is_rectified);
  depth.image.depth = depthFromMessage(part.depth, origin);
  depth.image.units_per_metre = 1000;
  // The depth camera may have a frame of its own.
  depth.T_base_camera = mountingOf(
      part.depth->header, part.depth->header.frame_id.empty() ? part.frame : "", origin, moment);
  depth.sensor = static_cast<uint32_t>(camera);
  bool image_is_used = false;
  for (const LiveInput::CameraImage& view : result->input.images) {
    if (view.origin != part.origin) continue;
    image_is_used = true;
    if (!view.mask.empty())
      depth.image.mask = {view.mask, view.camera,
                          view.T_base_camera.inverse() * depth.T_base_camera};
  }
  // The mask of the image also masks the depth image. When the image could not be used, its problem
  // is reported already.
  if (cues_ == Cues::kBoth && params_.use_masks && !image_is_used) return;
  if (cues_ == Cues::kDepth && params_.use_masks && part.match) {
    Moment::CameraPart named = part;
    named.origin = origin;
    const cv::Mat mask = maskFor(named, depth.image.camera, depth.T_base_camera, last, result);
    if (!mask.empty()) depth.image.mask = {mask, depth.image.camera, Pose::Identity()};
  }
  result->input.depths.push_back(std::move(depth));
}

namespace {

/// The latest stamp of the sensors of a moment.
ros::Time latestOf(const Moment& moment) {
  ros::Time latest = moment.stamp;
  const ros::Duration most(1);  // baseMotion() asks no farther
  const auto add = [&](const ros::Time& stamp) {
    if (stamp > latest && stamp - moment.stamp <= most) latest = stamp;
  };
  for (const Moment::CameraPart& part : moment.cameras) {
    if (part.match) add(part.match->image->header.stamp);
    if (part.depth) add(part.depth->header.stamp);
  }
  return latest;
}

}  // namespace

MomentInput MomentReader::read(const Moment& moment) {
  MomentInput result;
  result.input.time = moment.stamp.toSec();
  result.input.odometry = odometryAt(moment.stamp, latestOf(moment), &result.problem);
  result.input.up = upAt(moment.stamp, &result.problem);
  const auto attempt = [&](auto&& add) {
    try {
      add();
    } catch (const std::exception& e) {
      result.problem = e.what();
    }
  };
  for (size_t i = 0; i < moment.cameras.size(); ++i) {
    const Moment::CameraPart& part = moment.cameras[i];
    if (cues_ != Cues::kDepth)
      attempt([&] { addView(part, moment.stamp, &last_masks_[i], &result); });
    if (cues_ != Cues::kEdges)
      attempt([&] { addDepth(part, moment.stamp, i, &last_masks_[i], &result); });
  }
  return result;
}

}  // namespace edge_mcl
