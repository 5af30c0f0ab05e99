#include "edge_mcl/nodes/viewer/viewer_node.h"

#include <ros/console.h>
#include <ros/spinner.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "edge_mcl/core/base/clock_step.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_text.h"
#include "edge_mcl/nodes/common/caller_path.h"
#include "edge_mcl/nodes/messages/object_messages.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"
#include "edge_mcl/nodes/messages/sensor_mounting.h"

namespace edge_mcl {

std::vector<std::string> ViewerNodeParameters::faults() const {
  std::vector<std::string> list = ViewParameters::faults();
  if (headless && video.empty() && pictures.empty())
    list.emplace_back("parameter '~headless': '~video' or '~pictures' must be set as well");
  try {
    pictureTimes();
  } catch (const ParameterError& e) {
    list.emplace_back(e.what());
  }
  return list;
}

std::vector<double> ViewerNodeParameters::pictureTimes() const {
  std::vector<double> times;
  std::istringstream list(pictures_at);
  for (std::string entry; std::getline(list, entry, ',');) {
    double time = 0;
    if (!parameter_text::fromText(entry, &time) || (!times.empty() && time < times.back()))
      throw ParameterError(
          "parameter '~pictures_at': must be increasing numbers, separated by commas");
    times.push_back(time);
  }
  return times;
}

template <class Message>
boost::shared_ptr<const Message> LiveView::Kept<Message>::at(const ros::Time& stamp,
                                                             double tolerance) const {
  boost::shared_ptr<const Message> nearest;
  for (const auto& [time, message] : by_stamp) {
    const double off = std::abs((time - stamp).toSec());
    if (off > tolerance) continue;
    tolerance = off;
    nearest = message;
  }
  return nearest;
}

template <class Message>
void LiveView::subscribe(const std::string& topic, Kept<Message>* kept) {
  using Ptr = boost::shared_ptr<const Message>;
  subscribers_.push_back(nh_.subscribe<Message>(
      topic, 8, boost::function<void(const Ptr&)>([this, kept](const Ptr& message) {
        const std::lock_guard<std::mutex> lock(mutex_);
        kept->add(message);
      })));
}

LiveView::LiveView(const ros::NodeHandle& nh, const ViewerNodeParameters& params)
    : nh_(nh),
      params_(params),
      tf_listener_(tf_),
      transport_(nh),
      initial_pose_(nh_.advertise<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 1)) {
  const auto subscribeImage = [&](const char* topic, const std::string& transport,
                                  Kept<sensor_msgs::Image>* kept) {
    using Callback = boost::function<void(const sensor_msgs::ImageConstPtr&)>;
    image_subscribers_.emplace_back();
    image_subscribers_.back().subscribe(
        nh_, &transport_, topic, 4, transport,
        Callback([this, kept](const sensor_msgs::ImageConstPtr& message) {
          const std::lock_guard<std::mutex> lock(mutex_);
          kept->add(message);
        }));
  };
  subscribeImage("image", params_.image_transport.empty() ? "raw" : params_.image_transport,
                 &images_);
  is_rectified_ =
      params_.rectified == "true" ||
      (params_.rectified != "false" && isRectifiedTopic(image_subscribers_.front().topic()));
  subscribeImage("mask", "raw", &masks_);
  subscribeImage("depth", "raw", &depths_);
  subscribe("detections", &detections_);
  subscribe("foreign_objects", &foreign_);
  subscribe("pose", &poses_);
  subscribe("particlecloud", &clouds_);
  subscribe("hypotheses", &hypotheses_);
  subscribe("ground_truth", &truths_);
  const auto subscribeInfo = [&](const char* topic, sensor_msgs::CameraInfoConstPtr* info) {
    subscribers_.push_back(nh_.subscribe<sensor_msgs::CameraInfo>(
        topic, 1,
        boost::function<void(const sensor_msgs::CameraInfoConstPtr&)>(
            [this, info](const sensor_msgs::CameraInfoConstPtr& message) {
              const std::lock_guard<std::mutex> lock(mutex_);
              *info = message;
            })));
  };
  if (params_.camera_file.empty())
    subscribeInfo("camera_info", &info_);
  else
    info_ = boost::make_shared<sensor_msgs::CameraInfo>(
        toCameraInfo(CameraModel::fromYamlFile(callerPath(params_.camera_file)), {}, ""));
  subscribeInfo("depth/camera_info", &depth_info_);
  subscribers_.push_back(nh_.subscribe<Status>(
      "status", 50, boost::function<void(const StatusConstPtr&)>([this](const StatusConstPtr& m) {
        receiveStatus(m);
      })));
}

void LiveView::receiveStatus(const StatusConstPtr& status) {
  const std::lock_guard<std::mutex> lock(mutex_);
  status_at_ = ros::WallTime::now();
  restartIfTimeWentBack(status->header.stamp);
  pending_.push_back({status, status_at_});
  constexpr size_t kMost = 200;  // more waiting moments mean that the viewer is far behind
  if (pending_.size() > kMost) pending_.pop_front();
}

void LiveView::restartIfTimeWentBack(const ros::Time& stamp) {
  const ros::Time newest =
      pending_.empty() ? last_.value_or(stamp) : pending_.back().status->header.stamp;
  if (clockStep(newest.toSec(), stamp.toSec()) != ClockStep::kJumpedBack) return;
  history_.clear();
  pending_.clear();
  first_.reset();
  last_.reset();
  images_.by_stamp.clear();
  masks_.by_stamp.clear();
  depths_.by_stamp.clear();
  detections_.by_stamp.clear();
  foreign_.by_stamp.clear();
  poses_.by_stamp.clear();
  clouds_.by_stamp.clear();
  hypotheses_.by_stamp.clear();
  truths_.by_stamp.clear();
}

bool LiveView::isComplete(const Status& status) const {
  const ros::Time& stamp = status.header.stamp;
  // The viewer waits only for topics on which a message came within the last 2 s.
  const auto comes = [&](const ros::WallTime& last) {
    return !last.isZero() && (ros::WallTime::now() - last).toSec() < 2;
  };
  const bool has_pose = status.state != Status::UNINITIALIZED && status.state != Status::SEARCHING;
  return images_.has(stamp) && (!comes(masks_.last) || masks_.has(stamp)) &&
         (!comes(detections_.last) || detections_.has(stamp)) &&
         (!comes(foreign_.last) || foreign_.has(stamp)) &&
         (!has_pose || (poses_.has(stamp) && (!comes(clouds_.last) || clouds_.has(stamp))));
}

std::optional<Pose> LiveView::mountingOf(const std_msgs::Header& sensor) const {
  try {
    // The localizer takes the camera for the base where tf knows neither.
    if (!tf_._frameExists(frameName(sensor.frame_id))) return Pose::Identity();
    return sensorMounting(tf_, params_.base_frame_id, sensor, "tf");
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

void LiveView::addCamera(const sensor_msgs::ImageConstPtr& image, ViewMoment* m) {
  m->image = fromMessage(image, "image").clone();
  if (const auto mask = masks_.at(image->header.stamp, 0))
    m->mask = maskFromMessage(mask, "mask").clone();
  if (const auto found = detections_.at(image->header.stamp, 0))
    for (const DetectedObject& d : found->objects)
      m->objects.push_back({d.class_name, d.score, d.track_id, {d.x, d.y, d.width, d.height}});
  if (!info_) {
    m->problem += m->problem.empty() ? "no camera_info" : "; no camera_info";
    return;
  }
  m->camera = fromMessage(*info_, "camera_info", is_rectified_);
  if (m->camera.width != m->image.cols || m->camera.height != m->image.rows)
    throw InputError("camera_info has another size than the image");
  const std::optional<Pose> mounting = mountingOf(image->header);
  if (!mounting)
    throw InputError("no tf from " + params_.base_frame_id + " to the camera, '" +
                     image->header.frame_id + "'");
  m->T_base_camera = *mounting;
  m->has_camera = true;
}

void LiveView::addDepth(const ros::Time& stamp, ViewMoment* m) {
  const auto message = depths_.at(stamp, kDepthWindow);
  const sensor_msgs::CameraInfoConstPtr& info = depth_info_ ? depth_info_ : info_;
  if (!message || !info) return;
  DepthImage depth;
  depth.origin = "depth";
  depth.camera = fromMessage(*info, "depth camera_info");
  depth.depth = depthFromMessage(message, "depth");
  if (const auto mounting = mountingOf(message->header))
    m->depth_points = shownPoints(depth, *mounting);
}

ViewMoment LiveView::assemble(const Status& status) {
  const ros::Time& stamp = status.header.stamp;
  ViewMoment m;
  m.time = stamp.toSec();
  if (!first_) first_ = stamp;
  m.elapsed = (stamp - *first_).toSec();
  m.state = static_cast<LocalizerState>(std::min<uint8_t>(status.state, Status::SEARCHING));
  m.problem = status.problem;
  m.effective_sample_size = static_cast<double>(status.effective_sample_size);
  m.match_ratio = static_cast<double>(status.match_ratio);
  m.times.stage[0] = static_cast<double>(status.edges_ms);
  m.times.stage[1] = static_cast<double>(status.field_ms + status.table_ms);
  m.times.stage[2] = static_cast<double>(status.likelihood_ms);
  m.times.stage[3] = static_cast<double>(status.refinement_ms);
  m.times.stage[4] = static_cast<double>(status.search_ms);
  m.times.total = static_cast<double>(status.update_ms);
  const auto use = [&](const auto& part) {
    try {
      part();
    } catch (const Error& e) {
      m.problem += (m.problem.empty() ? "" : "; ") + std::string(e.what());
    }
  };
  use([&] {
    if (const auto pose = poses_.at(stamp, 0)) {
      m.estimate = fromMessage(pose->pose, "pose");
      m.has_pose = true;
    }
  });
  use([&] {
    if (const auto cloud = clouds_.at(stamp, 0)) {
      const size_t most = static_cast<size_t>(params_.max_particles);
      const size_t step = std::max<size_t>(1, (cloud->poses.size() + most - 1) / most);
      for (size_t i = 0; i < cloud->poses.size(); i += step)
        m.particles.push_back(fromMessage(cloud->poses[i], "particlecloud"));
      m.particle_count = cloud->poses.size();
    }
  });
  use([&] {
    if (const auto found = hypotheses_.at(stamp, 0))
      for (size_t i = 0; i < found->poses.size(); ++i)
        m.clusters.push_back({fromMessage(found->poses[i], "hypotheses"),
                              i < status.hypothesis_probabilities.size()
                                  ? static_cast<double>(status.hypothesis_probabilities[i])
                                  : 0.0,
                              0});
  });
  use([&] {
    for (const geometry_msgs::Pose& pose : status.next_view)
      m.next_view.push_back(fromMessage(pose, "next_view"));
  });
  use([&] {
    if (const auto found = foreign_.at(stamp, 0))
      for (const ForeignObject& object : found->objects) m.foreign.push_back(fromMessage(object));
  });
  constexpr double kSameMoment = 0.02;  // s
  use([&] {
    if (const auto truth = truths_.at(stamp, kSameMoment))
      m.truth = fromMessage(truth->pose, "ground_truth");
  });
  use([&] {
    if (const auto image = images_.at(stamp, 0)) addCamera(image, &m);
  });
  use([&] { addDepth(stamp, &m); });
  return m;
}

std::string LiveView::missing() const {
  constexpr double kLong = 2;  // s
  std::string text;
  const auto check = [&](const char* topic, const ros::WallTime& last) {
    const ros::WallTime since = last.isZero() ? started_ : last;
    if ((ros::WallTime::now() - since).toSec() < kLong) return;
    text += (text.empty() ? "nothing comes on: " : ", ") + nh_.resolveName(topic);
  };
  check("image", images_.last);
  check("status", status_at_);
  if (last_moment_.has_pose) {
    check("pose", poses_.last);
    check("particlecloud", clouds_.last);
  }
  return text;
}

bool LiveView::takeLocked(ViewMoment* moment) {
  // A viewer that is far behind leaves out moments whose images are forgotten. They would be empty.
  while (!pending_.empty() && images_.hasForgotten(pending_.front().status->header.stamp))
    pending_.pop_front();
  if (pending_.empty()) return false;
  const Pending& oldest = pending_.front();
  const bool waited = (ros::WallTime::now() - oldest.since).toSec() > params_.wait;
  if (!waited && !isComplete(*oldest.status)) return false;
  const StatusConstPtr status = oldest.status;
  pending_.pop_front();
  *moment = assemble(*status);
  last_ = status->header.stamp;
  const std::string not_there = missing();
  if (!not_there.empty()) moment->problem += (moment->problem.empty() ? "" : "; ") + not_there;
  last_moment_ = *moment;
  return true;
}

bool LiveView::nothingNew(ViewMoment* moment) {
  // Without a new moment, missing topics are reported once a second.
  if (!pending_.empty() || (ros::WallTime::now() - said_missing_at_).toSec() < 1) return false;
  const std::string not_there = missing();
  if (not_there.empty()) return false;
  said_missing_at_ = ros::WallTime::now();
  *moment = last_moment_;
  moment->problem = not_there;
  if (status_at_.isZero() && !images_.by_stamp.empty()) {
    try {
      moment->image = fromMessage(images_.by_stamp.rbegin()->second, "image").clone();
    } catch (const Error& e) {
      moment->problem += std::string("; ") + e.what();
    }
  }
  return true;
}

std::string LiveView::whatIsMissing() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return missing();
}

bool LiveView::hasStatus() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !status_at_.isZero();
}

void LiveView::setFrames(const std::string& global, const std::string& base) {
  const std::lock_guard<std::mutex> lock(mutex_);
  params_.global_frame_id = global;
  params_.base_frame_id = base;
}

bool LiveView::next(ViewMoment* moment) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return takeLocked(moment);
}

bool LiveView::poll(ViewMoment* moment, HistoryView* history, double strip_seconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  bool news = false;
  // All moments go into the history. The window shows the newest one.
  while (takeLocked(moment)) {
    history_.add(*moment);
    news = true;
  }
  if (!news && !nothingNew(moment)) return false;
  *history = history_.view(history_.size(), strip_seconds);
  return true;
}

void LiveView::setPose(const PoseGaussian& pose) {
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.stamp = ros::Time::now();
  message.header.frame_id = params_.global_frame_id;
  message.pose = toPoseMessage(pose);
  initial_pose_.publish(message);
  ROS_INFO("initial pose: %.2f %.2f %.2f m", message.pose.pose.position.x,
           message.pose.pose.position.y, message.pose.pose.position.z);
}

}  // namespace edge_mcl
