// The part of LocalizerNode that runs in its worker thread.
#include <ros/console.h>

#include <chrono>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/mask_motion.h"
#include "edge_mcl/nodes/localizer/localizer_node.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

/// Images that belong together.
struct LocalizerNode::Moment {
  ros::Time stamp;                                         ///< of the first camera's image
  std::vector<std::optional<MaskMatcher::Match>> matches;  ///< by camera
  std::vector<sensor_msgs::CameraInfoConstPtr> infos, depth_infos;
  std::vector<sensor_msgs::ImageConstPtr> depths;  ///< by camera; null: none
  uint32_t received = 0, dropped = 0;
};

void LocalizerNode::work() {
  while (running_) {
    const std::optional<Moment> moment = nextMoment();
    if (!moment) continue;
    try {
      process(*moment);
    } catch (const std::exception& e) {
      ROS_ERROR_THROTTLE(5, "an image could not be used: %s", e.what());
    }
  }
}

std::optional<LocalizerNode::Moment> LocalizerNode::nextMoment() {
  constexpr auto kPoll = std::chrono::milliseconds(10);  // for timeouts; input wakes it up
  std::unique_lock<std::mutex> lock(input_mutex_);
  const double now = ros::WallTime::now().toSec();
  const auto fresh = cameras_.front().matcher.take(now);
  if (!fresh) {
    input_ready_.wait_for(lock, kPoll);
    return std::nullopt;
  }
  Moment moment;
  moment.stamp = fresh->image->header.stamp;
  moment.matches.push_back(fresh);
  for (size_t i = 1; i < cameras_.size(); ++i)
    moment.matches.push_back(awaitImage(i, moment.stamp, now + params_.camera_timeout, &lock));
  for (size_t i = 0; i < cameras_.size(); ++i)
    moment.depths.push_back(awaitDepth(i, moment.stamp, &lock));
  for (const Camera& camera : cameras_) {
    moment.depth_infos.push_back(camera.depth_info);
    moment.infos.push_back(camera.info);
    moment.dropped += static_cast<uint32_t>(camera.matcher.dropped());
  }
  moment.received = images_received_;
  return moment;
}

std::optional<MaskMatcher::Match> LocalizerNode::awaitImage(size_t number, const ros::Time& stamp,
                                                            double until,
                                                            std::unique_lock<std::mutex>* lock) {
  // Images of one moment do not come at one moment.
  Camera& camera = cameras_[number];
  bool waited = false;
  while (running_) {
    const double now = ros::WallTime::now().toSec();
    const MaskMatcher::Near near = camera.matcher.takeNear(stamp, params_.camera_window, now);
    if (near.match) {
      camera.patience.found();
      return near.match;
    }
    const bool awaited =
        near.may_come && now < until && (waited || camera.patience.isWorthwhile(near.newest));
    if (!near.waits_for_mask && !awaited) {
      if (near.may_come) camera.patience.missed(near.newest, waited);
      return std::nullopt;
    }
    waited |= awaited;
    input_ready_.wait_for(*lock, std::chrono::milliseconds(2));
  }
  return std::nullopt;
}

sensor_msgs::ImageConstPtr LocalizerNode::awaitDepth(size_t number, const ros::Time& stamp,
                                                     std::unique_lock<std::mutex>* lock) {
  if (method_.likelihood.cues == Cues::kEdges) return nullptr;
  Camera& camera = cameras_[number];
  const double until = ros::WallTime::now().toSec() + params_.depth_timeout;
  bool waited = false;
  while (running_) {
    sensor_msgs::ImageConstPtr nearest;
    double least = params_.depth_window, newest = 0;
    for (const sensor_msgs::ImageConstPtr& depth : camera.depths) {
      const double offset = (depth->header.stamp - stamp).toSec();
      newest = std::max(newest, depth->header.stamp.toSec());
      if (std::abs(offset) > least) continue;
      least = std::abs(offset);
      nearest = depth;
    }
    if (newest >= stamp.toSec()) {  // a later one can only be farther away
      camera.depth_patience.found();
      return nearest;
    }
    const bool awaited = ros::WallTime::now().toSec() < until &&
                         (waited || camera.depth_patience.isWorthwhile(newest));
    if (!awaited) {
      camera.depth_patience.missed(newest, waited);
      return nearest;
    }
    waited = true;
    input_ready_.wait_for(*lock, std::chrono::milliseconds(2));
  }
  return nullptr;
}

std::optional<Pose> LocalizerNode::odometryAt(const ros::Time& stamp, std::string* problem) {
  if (params_.odometry == "none") return std::nullopt;
  const tf2::BufferCore& buffer = odometry_buffer_ ? *odometry_buffer_ : tf_;
  const std::string &odom = params_.odom_frame_id, &base = params_.base_frame_id;
  const auto newest = [&] {
    return buffer.canTransform(odom, base, ros::Time(0))
               ? buffer.lookupTransform(odom, base, ros::Time(0)).header.stamp
               : ros::Time(0);
  };
  // By the wall clock: a simulated one may stand still.
  const auto until = ros::WallTime::now() + ros::WallDuration(params_.transform_timeout);
  std::string why;
  bool waited = false;
  try {
    while (running_) {
      // Read first: what comes in between is seen by one of the two.
      const ros::Time at = newest();
      if (buffer.canTransform(odom, base, stamp, &why)) {
        odometry_patience_.found();
        return fromMessage(buffer.lookupTransform(odom, base, stamp).transform, "odometry");
      }
      const bool awaited = at <= stamp && ros::WallTime::now() < until &&
                           (waited || odometry_patience_.isWorthwhile(at.toSec()));
      if (!awaited) break;
      waited = true;
      ros::WallDuration(0.002).sleep();
    }
    odometry_patience_.missed(newest().toSec(), waited);
  } catch (const tf2::TransformException& e) {
    why = e.what();  // it was cleared in between: the clock jumped back
  }
  *problem = "no odometry for the image: " + why;
  return std::nullopt;
}

std::optional<UpReading> LocalizerNode::upAt(const ros::Time& stamp, std::string* problem) {
  if (!params_.use_imu) return std::nullopt;
  constexpr double kSameMoment = 0.05;  // s
  sensor_msgs::ImuConstPtr nearest;
  {
    const std::lock_guard<std::mutex> lock(input_mutex_);
    double least = kSameMoment;
    for (const sensor_msgs::ImuConstPtr& message : imu_) {
      const double offset = std::abs((message->header.stamp - stamp).toSec());
      if (offset > least) continue;
      least = offset;
      nearest = message;
    }
  }
  try {
    if (!nearest) throw InputError("no imu message for the image");
    if (nearest->orientation_covariance[0] == -1)
      throw InputError("imu: its messages hold no orientation");
    geometry_msgs::Pose pose;
    pose.orientation = nearest->orientation;
    const Eigen::Matrix3d R_world_imu = fromMessage(pose, "imu").linear();
    const Eigen::Matrix3d R_base_imu = mountingOf(nearest->header, "imu").linear();
    return UpReading{R_base_imu * R_world_imu.transpose() * Eigen::Vector3d::UnitZ(),
                     params_.imu_sigma};
  } catch (const std::exception& e) {
    *problem = e.what();
    return std::nullopt;
  }
}

cv::Mat LocalizerNode::maskFor(Camera* camera, const MaskMatcher::Match& match,
                               const CameraModel& model, const std::optional<Pose>& T_odom_camera,
                               bool* skip, double* age) {
  if (match.mask) {
    cv::Mat mask = maskFromMessage(match.mask, camera->origin + " mask");
    *age = 0;
    if (params_.mask_policy == "use_last") {
      camera->last_mask = mask.clone();
      camera->last_mask_at = match.image->header.stamp;
      camera->last_mask_rotation.reset();
      if (T_odom_camera) camera->last_mask_rotation = T_odom_camera->linear();
    }
    return mask;
  }
  if (params_.mask_policy == "skip_update") *skip = true;
  if (params_.mask_policy != "use_last" || camera->last_mask.empty()) return {};
  *age = (match.image->header.stamp - camera->last_mask_at).toSec();
  if (*age < 0) return {};  // of another time
  if (!T_odom_camera || !camera->last_mask_rotation) return camera->last_mask;
  return turnMask(camera->last_mask, model,
                  T_odom_camera->linear().transpose() * *camera->last_mask_rotation);
}

Pose LocalizerNode::mountingOf(const std_msgs::Header& header, const std::string& origin) const {
  const std::string &base = params_.base_frame_id, &frame = header.frame_id;
  ros::Time at = header.stamp;  // a gimbal turns
  std::string why;
  if (!tf_.canTransform(base, frame, at)) at = ros::Time(0);
  if (!tf_.canTransform(base, frame, at, ros::Duration(0), &why))
    throw InputError(origin + ": where is it on the robot? " + why);
  return fromMessage(tf_.lookupTransform(base, frame, at).transform, frame);
}

void LocalizerNode::addDepth(const Moment& moment, size_t number,
                             const std::optional<Pose>& odometry, LiveInput* input,
                             double* mask_age, std::string* problem) {
  Camera& camera = cameras_[number];
  const std::string origin = camera.origin + " depth";
  try {
    const sensor_msgs::ImageConstPtr& message = moment.depths[number];
    if (!message) throw InputError(origin + ": no depth image in time");
    // Registered to the colour camera, it may come without a calibration of its own.
    const sensor_msgs::CameraInfoConstPtr& info =
        moment.depth_infos[number] ? moment.depth_infos[number] : moment.infos[number];
    if (!info) throw InputError(origin + ": no camera_info yet");
    LiveInput::Depth depth;
    depth.image.origin = origin;
    depth.image.camera = fromMessage(*info, origin + " camera_info");
    depth.image.depth = depthFromMessage(message, origin);
    depth.image.units_per_metre = 1000;
    depth.T_base_camera = mountingOf(message->header, origin);
    depth.sensor = static_cast<uint32_t>(number);
    bool image_is_used = false;
    for (const LiveInput::View& view : input->views) {
      if (view.origin != camera.origin) continue;
      image_is_used = true;
      if (!view.mask.empty())
        depth.image.mask = {view.mask, view.camera,
                            view.T_base_camera.inverse() * depth.T_base_camera};
    }
    // The image's mask is the depth's; what became of it is told already.
    if (method_.likelihood.cues == Cues::kBoth && params_.use_masks && !image_is_used) return;
    if (method_.likelihood.cues == Cues::kDepth && params_.use_masks && moment.matches[number]) {
      std::optional<Pose> T_odom_camera;
      if (odometry) T_odom_camera = *odometry * depth.T_base_camera;
      bool skip = false;
      const cv::Mat mask = maskFor(&camera, *moment.matches[number], depth.image.camera,
                                   T_odom_camera, &skip, mask_age);
      if (skip) throw InputError(origin + ": no mask in time, image not used");
      if (!mask.empty()) depth.image.mask = {mask, depth.image.camera, Pose::Identity()};
    }
    input->depths.push_back(std::move(depth));
  } catch (const std::exception& e) {
    *problem = e.what();
  }
}

bool LocalizerNode::addView(const Moment& moment, size_t number,
                            const std::optional<Pose>& odometry, LiveInput* input, double* mask_age,
                            std::string* problem) {
  Camera& camera = cameras_[number];
  if (!moment.matches[number]) {
    *problem = camera.origin + ": no image of this moment";
    return false;
  }
  const MaskMatcher::Match& match = *moment.matches[number];
  try {
    if (!moment.infos[number]) throw InputError(camera.origin + ": no camera_info yet");
    LiveInput::View view;
    view.origin = camera.origin;
    view.camera = fromMessage(*moment.infos[number], camera.origin + " camera_info");
    view.image = fromMessage(match.image, camera.origin);
    view.T_base_camera = mountingOf(match.image->header, camera.origin);
    if (params_.use_masks) {
      std::optional<Pose> T_odom_camera;
      if (odometry) T_odom_camera = *odometry * view.T_base_camera;
      bool skip = false;
      view.mask = maskFor(&camera, match, view.camera, T_odom_camera, &skip, mask_age);
      if (skip) throw InputError(camera.origin + ": no mask in time, image not used");
    }
    input->views.push_back(std::move(view));
    return true;
  } catch (const std::exception& e) {
    *problem = e.what();
    return false;
  }
}

void LocalizerNode::process(const Moment& moment) {
  const auto begin = std::chrono::steady_clock::now();
  ResultContext context;
  context.stamp = moment.stamp;
  std::string problem;
  context.odometry = odometryAt(moment.stamp, &problem);
  LiveInput input;
  input.time = moment.stamp.toSec();
  input.odometry = context.odometry;
  input.up = upAt(moment.stamp, &problem);
  for (size_t i = 0; i < moment.matches.size(); ++i) {
    if (method_.likelihood.cues != Cues::kDepth)
      addView(moment, i, context.odometry, &input, &context.mask_age, &problem);
    if (method_.likelihood.cues != Cues::kEdges)
      addDepth(moment, i, context.odometry, &input, &context.mask_age, &problem);
  }

  const std::lock_guard<std::mutex> lock(localizer_mutex_);
  input.force_update = force_update_;
  force_update_ = false;
  LiveResult result = localizer_->process(input);
  for (const size_t number : result.image_numbers)
    context.T_base_camera.push_back(input.views[number].T_base_camera);
  if (!problem.empty() && (result.problem.empty() || (input.views.empty() && input.depths.empty())))
    result.problem = problem;
  if (result.updated) ++updates_;
  context.images_received = moment.received;
  context.images_dropped = moment.dropped;
  context.updates = updates_;
  context.update_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  if (result.restarted) ROS_WARN("%s", result.problem.c_str());
  if (!result.problem.empty())
    ROS_WARN_THROTTLE(5, "%s: %s", nameOf(result.state), result.problem.c_str());
  publisher_->publish(result, *localizer_, context);
  last_image_at_ = ros::WallTime::now();
  last_update_ms_ = context.update_ms;
  last_result_ = std::move(result);
  last_result_.images.clear();  // they are large
}

}  // namespace edge_mcl
