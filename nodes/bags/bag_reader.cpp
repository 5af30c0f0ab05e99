#include "edge_mcl/nodes/bags/bag_reader.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"
#include "edge_mcl/nodes/messages/sensor_mounting.h"

namespace edge_mcl {

struct BagReader::Impl {
  std::string file;
  BagTopics topics;
  rosbag::Bag bag;
  std::unique_ptr<tf2::BufferCore> transforms;
  std::unique_ptr<tf2::BufferCore> odometry;  // from messages; null: tf has it
  std::optional<CameraModel> camera, depth_camera;
  std::optional<PoseGaussian> initial_pose;
  Trajectory truth;
  /// Images of another topic (masks or depth) that belong to the images of the camera. They are
  /// read ahead, because they may be recorded later than their image.
  struct Companion {
    std::unique_ptr<rosbag::View> view;
    rosbag::View::iterator next;
    std::map<ros::Time, sensor_msgs::ImageConstPtr> waiting;

    void open(const rosbag::Bag& from, const std::string& topic) {
      view = std::make_unique<rosbag::View>(from, rosbag::TopicQuery(topic));
      next = view->begin();
    }
    /// The image nearest to a stamp, within `tolerance` seconds; null: there is none. Images that
    /// are more than 0.1 s older are forgotten.
    sensor_msgs::ImageConstPtr take(const ros::Time& stamp, const ros::Time& received,
                                    double tolerance) {
      if (!view) return nullptr;
      constexpr double kLatest = 2;  // s that it may be recorded after its image
      while ((waiting.empty() || waiting.rbegin()->first < stamp) && next != view->end() &&
             (*next).getTime() <= received + ros::Duration(kLatest)) {
        if (const auto message = (*next).instantiate<sensor_msgs::Image>())
          waiting[message->header.stamp] = message;
        ++next;
      }
      sensor_msgs::ImageConstPtr nearest;
      for (const auto& [at, message] : waiting) {
        const double offset = std::abs((at - stamp).toSec());
        if (offset > tolerance) continue;
        tolerance = offset;
        nearest = message;
      }
      const ros::Duration kept(0.1);
      if (stamp.toSec() > kept.toSec())
        waiting.erase(waiting.begin(), waiting.lower_bound(stamp - kept));
      return nearest;
    }
  };
  std::unique_ptr<rosbag::View> images;
  rosbag::View::iterator image;
  Companion masks, depths;

  void readTransforms() {
    rosbag::View all(bag);
    if (all.size() == 0) throw InputError(file + ": the bag has no messages");
    transforms = std::make_unique<tf2::BufferCore>(
        ros::Duration((all.getEndTime() - all.getBeginTime()).toSec() + 60));
    rosbag::View view(bag, rosbag::TopicQuery(std::vector<std::string>{"/tf", "/tf_static", "tf"}));
    for (const rosbag::MessageInstance& m : view) {
      const auto message = m.instantiate<tf2_msgs::TFMessage>();
      if (!message) continue;
      for (const auto& t : message->transforms)
        transforms->setTransform(t, "bag", m.getTopic() == "/tf_static");
    }
  }

  /// Reads odometry from messages when tf has no odometry.
  void readOdometry() {
    const std::string &odom = topics.odom_frame, &base = topics.base_frame;
    if (odom.empty() || topics.odometry.empty() ||
        transforms->canTransform(odom, base, ros::Time(0)))
      return;
    rosbag::View view(bag, rosbag::TopicQuery(topics.odometry));
    odometry = std::make_unique<tf2::BufferCore>(transforms->getCacheLength());
    for (const rosbag::MessageInstance& m : view) {
      const auto message = m.instantiate<nav_msgs::Odometry>();
      if (!message) continue;
      try {
        const Pose pose = fromMessage(message->pose.pose, topics.odometry);
        odometry->setTransform(toTransformStamped(pose, message->header.stamp, odom, base), "bag");
      } catch (const InputError&) {
        // The message is left out, as in the node. An image at that time has no odometry.
      }
    }
  }

  void readSmallThings() {
    rosbag::View view(
        bag, rosbag::TopicQuery(std::vector<std::string>{topics.camera_info, topics.depth_info,
                                                         topics.initial_pose, topics.truth}));
    for (const rosbag::MessageInstance& m : view) {
      if (m.getTopic() == topics.camera_info && !camera) {
        if (const auto info = m.instantiate<sensor_msgs::CameraInfo>())
          camera = fromMessage(*info, file + ": " + topics.camera_info);
      } else if (m.getTopic() == topics.depth_info && !depth_camera) {
        if (const auto info = m.instantiate<sensor_msgs::CameraInfo>())
          depth_camera = fromMessage(*info, file + ": " + topics.depth_info);
      } else if (const auto pose = m.instantiate<geometry_msgs::PoseWithCovarianceStamped>()) {
        if (m.getTopic() == topics.initial_pose && !initial_pose)
          initial_pose = fromMessage(pose->pose, file + ": " + topics.initial_pose);
      } else if (const auto stamped = m.instantiate<geometry_msgs::PoseStamped>()) {
        char time[32];
        std::snprintf(time, sizeof time, "%.6f", stamped->header.stamp.toSec());
        truth.push_back({stamped->header.stamp.toSec(), time,
                         fromMessage(stamped->pose, file + ": " + topics.truth)});
      }
    }
    if (!camera) throw InputError(file + ": no camera_info on " + topics.camera_info);
  }

  Pose mountingOf(const std_msgs::Header& header, const std::string& where) const {
    return sensorMounting(*transforms, topics.base_frame, header, where);
  }

  LiveInput::CameraImage viewOf(const sensor_msgs::ImageConstPtr& message,
                                const ros::Time& received) {
    const std::string where = file + " at " + std::to_string(message->header.stamp.toSec());
    LiveInput::CameraImage view;
    view.origin = where;
    view.camera = *camera;
    // Copied, because the message is deleted after this moment.
    view.image = fromMessage(message, where).clone();
    if (const auto m = masks.take(message->header.stamp, received, 0))
      view.mask = maskFromMessage(m, where + ": mask").clone();
    view.T_base_camera = mountingOf(message->header, where);
    return view;
  }

  void addDepth(const LiveInput::CameraImage& view, const ros::Time& stamp,
                const ros::Time& received, LiveInput* input) {
    const auto message = depths.take(stamp, received, kDepthWindow);
    if (!message) return;
    LiveInput::Depth depth;
    depth.image.origin = view.origin + ": depth";
    depth.image.camera = depth_camera ? *depth_camera : *camera;
    depth.image.depth = depthFromMessage(message, depth.image.origin).clone();
    depth.T_base_camera = mountingOf(message->header, depth.image.origin);
    if (!view.mask.empty())
      depth.image.mask = {view.mask, view.camera,
                          view.T_base_camera.inverse() * depth.T_base_camera};
    input->depths.push_back(std::move(depth));
  }
};

BagReader::BagReader(const std::string& file, BagTopics topics) : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  m.file = file;
  m.topics = std::move(topics);
  try {
    m.bag.open(file, rosbag::bagmode::Read);
    m.readTransforms();
    m.readOdometry();
    m.readSmallThings();
    m.images = std::make_unique<rosbag::View>(m.bag, rosbag::TopicQuery(m.topics.image));
    m.image = m.images->begin();
    if (!m.topics.mask.empty()) m.masks.open(m.bag, m.topics.mask);
    if (!m.topics.depth.empty()) m.depths.open(m.bag, m.topics.depth);
  } catch (const rosbag::BagException& e) {
    throw InputError(file + ": cannot be read as a bag: " + e.what());
  }
  if (m.images->size() == 0) {
    std::string there;
    rosbag::View all(m.bag);
    for (const rosbag::ConnectionInfo* c : all.getConnections())
      if (c->datatype == "sensor_msgs/Image") there += " " + c->topic;
    throw InputError(file + ": no images on " + m.topics.image +
                     "; topics with images:" + (there.empty() ? " none" : there));
  }
}

BagReader::~BagReader() = default;

size_t BagReader::imageCount() const { return impl_->images->size(); }
const std::optional<PoseGaussian>& BagReader::initialPose() const { return impl_->initial_pose; }
const Trajectory& BagReader::truth() const { return impl_->truth; }

bool BagReader::next(LiveInput* input, std::string* problem) {
  Impl& m = *impl_;
  *input = {};
  problem->clear();
  if (m.image == m.images->end()) return false;
  input->time = (*m.image).getTime().toSec();  // used when the stamp cannot be read
  try {
    const auto message = (*m.image).instantiate<sensor_msgs::Image>();
    if (!message) throw InputError(m.file + ": " + m.topics.image + " is not a sensor_msgs/Image");
    const ros::Time stamp = message->header.stamp;
    input->time = stamp.toSec();
    const std::string &odom = m.topics.odom_frame, &base = m.topics.base_frame;
    const tf2::BufferCore& odometry = m.odometry ? *m.odometry : *m.transforms;
    if (!odom.empty() && odometry.canTransform(odom, base, stamp))
      input->odometry =
          fromMessage(odometry.lookupTransform(odom, base, stamp).transform, "odometry");
    const ros::Time received = (*m.image).getTime();
    input->images.push_back(m.viewOf(message, received));
    m.addDepth(input->images.back(), stamp, received, input);
  } catch (const std::exception& e) {
    *problem = e.what();
  }
  ++m.image;
  return true;
}

}  // namespace edge_mcl
