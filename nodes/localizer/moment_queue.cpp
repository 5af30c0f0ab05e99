#include "edge_mcl/nodes/localizer/moment_queue.h"

#include <ros/console.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "edge_mcl/core/base/clock_step.h"
#include "edge_mcl/nodes/common/caller_path.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

namespace {

/// Time between two looks for data that are awaited. It is short beside the 30 ms of a camera.
constexpr auto kPoll = std::chrono::milliseconds(2);

double wallNow() { return ros::WallTime::now().toSec(); }

/// The image with the time of its arrival where it has no stamp.
sensor_msgs::ImageConstPtr withStamp(const sensor_msgs::ImageConstPtr& image) {
  if (!image->header.stamp.isZero()) return image;
  ROS_WARN_ONCE(
      "there are images without a stamp; the time of their arrival is used, and masks do not find "
      "them");
  const auto stamped = boost::make_shared<sensor_msgs::Image>(*image);
  stamped->header.stamp = ros::Time::now();
  return stamped;
}

}  // namespace

MomentQueue::MomentQueue(const ros::NodeHandle& nh, const NodeParameters& params, Cues cues)
    : params_(params), cues_(cues), transport_(nh) {
  for (const std::string& name : params_.cameraNames()) {
    cameras_.emplace_back(params_.use_masks, params_.mask_timeout);
    cameras_.back().name = name;
    cameras_.back().origin = name.empty() ? "camera" : name;
    cameras_.back().frame = frameName(params_.cameraFrames()[cameras_.size() - 1]);
  }
  // The vector does not grow any more, so callbacks may keep the number of a camera.
  for (size_t i = 0; i < cameras_.size(); ++i) subscribe(nh, i);
}

void MomentQueue::stop() {
  running_ = false;
  changed_.notify_all();
}

void MomentQueue::subscribe(ros::NodeHandle nh, size_t i) {
  using Callback = boost::function<void(const sensor_msgs::ImageConstPtr&)>;
  Camera& camera = cameras_[i];
  const std::string prefix = camera.name.empty() ? "" : camera.name + "/";
  const auto keepInfo = [&](const std::string& topic, sensor_msgs::CameraInfoConstPtr* kept) {
    return nh.subscribe<sensor_msgs::CameraInfo>(
        topic, 1,
        boost::function<void(const sensor_msgs::CameraInfoConstPtr&)>(
            [this, kept](const sensor_msgs::CameraInfoConstPtr& info) {
              const std::lock_guard<std::mutex> lock(mutex_);
              *kept = info;
            }));
  };
  // A calibration file takes the place of the topic.
  const std::string file = callerPath(params_.cameraFiles()[i]);
  if (file.empty())
    camera.info_subscriber = keepInfo(prefix + "camera_info", &camera.info);
  else
    camera.info = boost::make_shared<sensor_msgs::CameraInfo>(
        toCameraInfo(CameraModel::fromYamlFile(file), {}, ""));
  if (cues_ != Cues::kDepth)
    camera.image_subscriber.subscribe(nh, &transport_, prefix + "image", 5, params_.image_transport,
                                      Callback([this, i](const sensor_msgs::ImageConstPtr& m) {
                                        receiveImage(i, withStamp(m));
                                      }));
  if (cues_ != Cues::kEdges) {
    camera.depth_info_subscriber = keepInfo(prefix + "depth/camera_info", &camera.depth_info);
    camera.depth_subscriber.subscribe(nh, &transport_, prefix + "depth", 2, params_.depth_transport,
                                      Callback([this, i](const sensor_msgs::ImageConstPtr& m) {
                                        receiveDepth(i, withStamp(m));
                                      }));
  }
  camera.is_rectified = params_.isRectified(camera.image_subscriber.topic());
  camera.is_depth_rectified = isRectifiedTopic(camera.depth_subscriber.topic());
  if (params_.use_masks)
    camera.mask_subscriber.subscribe(nh, &transport_, prefix + "mask", 5, "raw",
                                     Callback([this, i](const sensor_msgs::ImageConstPtr& mask) {
                                       const std::lock_guard<std::mutex> lock(mutex_);
                                       cameras_[i].matcher.addMask(mask);
                                       changed_.notify_all();
                                     }));
}

std::string MomentQueue::silentTopic() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Camera& camera = cameras_.front();
  if (images_received_ > 0) return {};
  return cues_ == Cues::kDepth ? camera.depth_subscriber.topic() : camera.image_subscriber.topic();
}

void MomentQueue::receiveImage(size_t camera, const sensor_msgs::ImageConstPtr& image) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++images_received_;
  cameras_[camera].matcher.addImage(image, wallNow());
  changed_.notify_all();
}

void MomentQueue::receiveDepth(size_t camera, const sensor_msgs::ImageConstPtr& depth) {
  constexpr size_t kKept = 64;  // as many as images that may wait for their masks
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::deque<sensor_msgs::ImageConstPtr>& depths = cameras_[camera].depths;
    if (!depths.empty() && clockStep(depths.back()->header.stamp.toSec(),
                                     depth->header.stamp.toSec()) == ClockStep::kJumpedBack)
      depths.clear();
    depths.push_back(depth);
    if (depths.size() > kKept) depths.pop_front();
  }
  // Without images the depth images start the moments.
  if (cues_ == Cues::kDepth)
    receiveImage(camera, depth);
  else
    changed_.notify_all();
}

std::optional<Moment> MomentQueue::next() {
  constexpr auto kLongestWait = std::chrono::milliseconds(10);  // new data end the wait
  std::unique_lock<std::mutex> lock(mutex_);
  const double now = wallNow();
  const auto first = cameras_.front().matcher.take(now);
  if (!first) {
    changed_.wait_for(lock, kLongestWait);
    return std::nullopt;
  }
  Moment moment;
  moment.stamp = first->image->header.stamp;
  moment.cameras.resize(cameras_.size());
  moment.cameras.front().match = first;
  for (size_t i = 1; i < cameras_.size(); ++i)
    moment.cameras[i].match =
        awaitImage(&cameras_[i], moment.stamp, now + params_.camera_timeout, &lock);
  for (size_t i = 0; i < cameras_.size(); ++i)
    moment.cameras[i].depth = awaitDepth(&cameras_[i], moment.stamp, &lock);
  for (size_t i = 0; i < cameras_.size(); ++i) {
    const Camera& camera = cameras_[i];
    moment.cameras[i].origin = camera.origin;
    moment.cameras[i].info = camera.info;
    moment.cameras[i].depth_info = camera.depth_info;
    moment.cameras[i].frame = camera.frame;
    moment.cameras[i].is_rectified = camera.is_rectified;
    moment.cameras[i].is_depth_rectified = camera.is_depth_rectified;
    moment.dropped += static_cast<uint32_t>(camera.matcher.dropped());
  }
  moment.received = images_received_;
  return moment;
}

std::optional<MaskMatcher::Match> MomentQueue::awaitImage(Camera* camera, const ros::Time& stamp,
                                                          double until,
                                                          std::unique_lock<std::mutex>* lock) {
  const auto look = [&] {
    const MaskMatcher::Near near =
        camera->matcher.takeNear(stamp, params_.camera_window, wallNow());
    return Look<MaskMatcher::Match>{near.match, near.may_come, near.waits_for_mask, near.newest};
  };
  return awaitData<MaskMatcher::Match>(
      &camera->patience, look, [&] { return wallNow() < until; },
      [&] { changed_.wait_for(*lock, kPoll); }, [&] { return running_.load(); });
}

sensor_msgs::ImageConstPtr MomentQueue::awaitDepth(Camera* camera, const ros::Time& stamp,
                                                   std::unique_lock<std::mutex>* lock) {
  if (cues_ == Cues::kEdges) return nullptr;
  const double until = wallNow() + params_.depth_timeout;
  sensor_msgs::ImageConstPtr nearest;
  const auto look = [&] {
    Look<sensor_msgs::ImageConstPtr> now;
    now.may_come = true;
    nearest = nullptr;
    double least = params_.depth_window;
    for (const sensor_msgs::ImageConstPtr& depth : camera->depths) {
      const double offset = std::abs((depth->header.stamp - stamp).toSec());
      now.newest = std::max(now.newest, depth->header.stamp.toSec());
      if (offset > least) continue;
      least = offset;
      nearest = depth;
    }
    // A later depth image can only be farther away.
    if (now.newest >= stamp.toSec()) now.found = nearest;
    return now;
  };
  awaitData<sensor_msgs::ImageConstPtr>(
      &camera->depth_patience, look, [&] { return wallNow() < until; },
      [&] { changed_.wait_for(*lock, kPoll); }, [&] { return running_.load(); });
  return running_ ? nearest : nullptr;
}

}  // namespace edge_mcl
