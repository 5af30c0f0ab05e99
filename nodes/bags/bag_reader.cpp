#include "edge_mcl/nodes/bags/bag_reader.h"

#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/bags/bag_images.h"
#include "edge_mcl/nodes/bags/bag_set.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"
#include "edge_mcl/nodes/messages/sensor_mounting.h"

namespace edge_mcl {

namespace {

bool contains(const std::string& text, const char* part) {
  return text.find(part) != std::string::npos;
}

/// The topic camera_info beside a topic of images, as image_transport has it.
std::string infoBeside(const std::string& images) {
  const std::string raw = uncompressedTopic(images);
  const auto slash = raw.rfind('/');
  return (slash == std::string::npos ? "" : raw.substr(0, slash + 1)) + "camera_info";
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace

struct BagReader::Impl {
  explicit Impl(const std::vector<std::string>& files, BagTopics names)
      : file(files.front()),
        topics(std::move(names)),
        bags(files),
        mounting(topics.base_frame, 0) {}

  std::string file;
  BagTopics topics;
  BagSet bags;
  std::unique_ptr<tf2::BufferCore> transforms;
  std::unique_ptr<tf2::BufferCore> odometry;  // from messages; null: tf has it
  std::optional<CameraModel> camera, depth_camera;
  bool is_rectified = false, is_depth_rectified = false;
  std::optional<PoseGaussian> initial_pose;
  Trajectory truth;
  std::unique_ptr<rosbag::View> images;
  rosbag::View::iterator image;
  CompanionImages masks, depths;
  CameraMounting mounting;
  /// Is added to the stamps of images and depth images of a camera with a clock of its own.
  ros::Duration clock_offset;
  std::vector<std::string> notes;

  /// Finds the topics of the images. @throws InputError when the bag has no images
  void findTopics() {
    const bool is_default = topics.image == BagTopics().image;
    topics.image = bags.recordedTopic(topics.image);
    if (!bags.has(topics.image)) {
      std::vector<std::string> found = bags.imageTopics();
      const std::vector<std::string> all = found;
      found.erase(std::remove_if(found.begin(), found.end(),
                                 [](const std::string& topic) {
                                   return contains(topic, "depth") || contains(topic, "mask");
                                 }),
                  found.end());
      if (found.size() != 1 || !is_default)
        throw InputError(file + ": no images on " + topics.image + "; topics with images: " +
                         joined(all) + (all.empty() ? "" : "; name one with --topics image=..."));
      notes.push_back("the images are those on " + found.front());
      topics.image = found.front();
    }
    if (topics.camera_info.empty()) topics.camera_info = infoBeside(topics.image);
    if (!topics.depth.empty()) topics.depth = bags.recordedTopic(topics.depth);
    if (topics.depth_info.empty() && !topics.depth.empty())
      topics.depth_info = infoBeside(topics.depth);
    if (!topics.mask.empty()) topics.mask = bags.recordedTopic(topics.mask);
    for (std::string* frame : {&topics.odom_frame, &topics.base_frame, &topics.camera_frame})
      *frame = frameName(*frame);
    is_rectified = topics.rectified == "true" ||
                   (topics.rectified == "auto" && isRectifiedTopic(topics.image));
    is_depth_rectified = isRectifiedTopic(topics.depth);
    if (is_rectified && camera && camera->distortion != DistortionModel::kNone) {
      camera->distortion = DistortionModel::kNone;
      camera->coefficients = {};
      camera->validate(file);
      notes.emplace_back(
          "the images are rectified, so the distortion of the calibration file is not "
          "used; --topics rectified=false uses it");
    }
  }

  void readTransforms() {
    const auto all = bags.view();
    if (all->size() == 0) throw InputError(file + ": the bag has no messages");
    transforms = std::make_unique<tf2::BufferCore>(
        ros::Duration((all->getEndTime() - all->getBeginTime()).toSec() + 60));
    // Old bags have the type of tf1, with the same content. A robot's tf may have a namespace.
    const auto view = bags.view(bags.topicsOf({"tf2_msgs/TFMessage", "tf/tfMessage"}));
    for (const rosbag::MessageInstance& m : *view) {
      const auto message = m.instantiate<tf2_msgs::TFMessage>();
      if (!message) continue;
      for (const auto& t : message->transforms)
        transforms->setTransform(t, "bag", contains(m.getTopic(), "tf_static"));
    }
  }

  /// Reads odometry from messages when tf has no odometry.
  void readOdometry() {
    const std::string &odom = topics.odom_frame, &base = topics.base_frame;
    if (odom.empty() || topics.odometry.empty() ||
        transforms->canTransform(odom, base, ros::Time(0)))
      return;
    const auto view = bags.view({topics.odometry});
    odometry = std::make_unique<tf2::BufferCore>(transforms->getCacheLength());
    for (const rosbag::MessageInstance& m : *view) {
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
    const auto view =
        bags.view({topics.camera_info, topics.depth_info, topics.initial_pose, topics.truth});
    std::string why;  // a calibration cannot be used
    for (const rosbag::MessageInstance& m : *view) {
      if (const auto info = m.instantiate<sensor_msgs::CameraInfo>()) {
        if (m.getTopic() == topics.camera_info && !camera) try {
            camera = fromMessage(*info, file + ": " + topics.camera_info, is_rectified);
          } catch (const InputError& e) {
            why = e.what();  // drivers send zeros until they are calibrated
          }
        if (m.getTopic() == topics.depth_info && !depth_camera)
          depth_camera = fromMessage(*info, file + ": " + topics.depth_info, is_depth_rectified);
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
    if (!camera && !why.empty()) throw InputError(why);
    if (!camera)
      throw InputError(file + ": no camera_info on " + topics.camera_info +
                       "; name a calibration file with --camera, or the topic with --topics "
                       "camera_info=...; topics with camera_info: " +
                       joined(bags.topicsOf({"sensor_msgs/CameraInfo"})));
  }

  const tf2::BufferCore& odometryBuffer() const { return odometry ? *odometry : *transforms; }

  bool knowsOdometry(const ros::Time& stamp) const {
    return !topics.odom_frame.empty() &&
           odometryBuffer().canTransform(topics.odom_frame, topics.base_frame, stamp);
  }

  /// Looks at the first image: where its camera is, and whether its clock is that of the recording.
  void lookAhead() {
    images = bags.view({topics.image});
    image = images->begin();
    sensor_msgs::ImageConstPtr first;
    try {
      first = imageOf(*image);
      if (first) mounting.of(*transforms, first->header, topics.camera_frame, file);
    } catch (const std::exception&) {
      // next() tells it.
    }
    for (std::string& note : mounting.takeNotes()) notes.push_back(std::move(note));
    if (!first) return;
    if (first->header.stamp == (*image).getTime())
      if (const auto raw = (*image).instantiate<sensor_msgs::Image>();
          raw && raw->header.stamp.isZero())
        notes.emplace_back(
            "images without a stamp: the times at which they were recorded are used");
    if (const auto offset = clockOffset()) {
      clock_offset = *offset;
      char text[160];
      std::snprintf(
          text, sizeof text,
          "the stamps of the images are %.1f s %s the recording: the camera has a clock of "
          "its own; its stamps are shifted by that",
          std::abs(offset->toSec()), offset->toSec() > 0 ? "behind" : "ahead of");
      notes.emplace_back(text);
    }
  }

  /// Time of recording minus stamp, when it is large, the same for the first images, and brings
  /// them to times that odometry knows. A single wrong stamp is no other clock.
  std::optional<ros::Duration> clockOffset() const {
    constexpr double kOtherClock = 5, kSame = 1;  // s; no driver takes so long
    constexpr size_t kImages = 10;
    std::vector<double> offsets;
    ros::Time first;
    for (rosbag::View::iterator it = images->begin(); it != images->end(); ++it) {
      const auto stamp = stampIn(*it);
      if (!stamp) continue;
      if (offsets.empty()) first = *stamp;
      offsets.push_back((*it).getTime().toSec() - stamp->toSec());
      if (offsets.size() == kImages) break;
    }
    if (offsets.size() < 2) return std::nullopt;
    std::vector<double> sorted = offsets;
    std::sort(sorted.begin(), sorted.end());
    const double median = sorted[sorted.size() / 2];
    if (std::abs(median) < kOtherClock || sorted.back() - sorted.front() > kSame ||
        knowsOdometry(first) || !knowsOdometry(images->begin()->getTime()))
      return std::nullopt;
    // To the nanosecond, since tf knows no time after its last one.
    return images->begin()->getTime() - first;
  }

  ros::Time timeOf(const std_msgs::Header& header) const { return header.stamp + clock_offset; }

  LiveInput::CameraImage viewOf(const sensor_msgs::ImageConstPtr& message,
                                const ros::Time& received) {
    const std::string where = file + " at " + std::to_string(timeOf(message->header).toSec());
    LiveInput::CameraImage view;
    view.origin = where;
    view.camera = *camera;
    // Copied, because the message is deleted after this moment.
    view.image = fromMessage(message, where).clone();
    if (const auto m = masks.take(message->header.stamp, received, 0))
      view.mask = maskFromMessage(m, where + ": mask").clone();
    view.T_base_camera = mountingOf(message->header, topics.camera_frame, where);
    return view;
  }

  Pose mountingOf(const std_msgs::Header& header, const std::string& frame,
                  const std::string& where) {
    std_msgs::Header shifted = header;
    shifted.stamp = timeOf(header);
    return mounting.of(*transforms, shifted, frame, where);
  }

  void addDepth(const LiveInput::CameraImage& view, const ros::Time& stamp,
                const ros::Time& received, LiveInput* input) {
    const auto message = depths.take(stamp, received, kDepthWindow);
    if (!message) return;
    LiveInput::Depth depth;
    depth.image.origin = view.origin + ": depth";
    depth.image.camera = depth_camera ? *depth_camera : *camera;
    depth.image.depth = depthFromMessage(message, depth.image.origin).clone();
    depth.T_base_camera =
        mountingOf(message->header, message->header.frame_id.empty() ? topics.camera_frame : "",
                   depth.image.origin);
    if (!view.mask.empty())
      depth.image.mask = {view.mask, view.camera,
                          view.T_base_camera.inverse() * depth.T_base_camera};
    input->depths.push_back(std::move(depth));
  }
};

BagReader::BagReader(const std::vector<std::string>& files, BagTopics topics,
                     const std::optional<CameraModel>& camera)
    : impl_(std::make_unique<Impl>(files, std::move(topics))) {
  Impl& m = *impl_;
  m.camera = camera;
  try {
    m.readTransforms();
    m.findTopics();
    m.readOdometry();
    m.readSmallThings();
    if (!m.topics.mask.empty()) m.masks.open(m.bags, m.topics.mask);
    if (!m.topics.depth.empty()) m.depths.open(m.bags, m.topics.depth);
    m.lookAhead();
  } catch (const rosbag::BagException& e) {
    throw InputError(m.file + ": cannot be read as a bag: " + e.what());
  }
}

BagReader::~BagReader() = default;

size_t BagReader::imageCount() const { return impl_->images->size(); }
const std::optional<PoseGaussian>& BagReader::initialPose() const { return impl_->initial_pose; }
const Trajectory& BagReader::truth() const { return impl_->truth; }
bool BagReader::hasDepth() const {
  return !impl_->topics.depth.empty() && impl_->bags.has(impl_->topics.depth);
}
std::vector<std::string> BagReader::notes() const { return impl_->notes; }

bool BagReader::next(LiveInput* input, std::string* problem) {
  Impl& m = *impl_;
  *input = {};
  problem->clear();
  if (m.image == m.images->end()) return false;
  input->time = (*m.image).getTime().toSec();  // used when the stamp cannot be read
  try {
    // An image that cannot be decoded keeps its place in time.
    if (const auto known = stampIn(*m.image); known && !known->isZero())
      input->time = (*known + m.clock_offset).toSec();
    const auto message = imageOf(*m.image);
    if (!message) throw InputError(m.file + ": " + m.topics.image + " holds no images");
    const ros::Time stamp = m.timeOf(message->header);
    input->time = stamp.toSec();
    if (m.knowsOdometry(stamp) && !m.mounting.isBase())
      input->odometry =
          fromMessage(m.odometryBuffer()
                          .lookupTransform(m.topics.odom_frame, m.topics.base_frame, stamp)
                          .transform,
                      "odometry");
    const ros::Time received = (*m.image).getTime();
    input->images.push_back(m.viewOf(message, received));
    m.addDepth(input->images.back(), message->header.stamp, received, input);
  } catch (const std::exception& e) {
    *problem = e.what();
  }
  ++m.image;
  return true;
}

}  // namespace edge_mcl
