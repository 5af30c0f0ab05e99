#include "edge_mcl/nodes/detector/detector_node.h"

#include <edge_mcl/DetectedObjects.h>
#include <ros/console.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/eight_bits.h"
#include "edge_mcl/detector/default_model.h"
#include "edge_mcl/detector/detection_overlay.h"
#include "edge_mcl/nodes/common/caller_path.h"
#include "edge_mcl/nodes/common/private_parameters.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

DetectorNode::DetectorNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh)
    : params_(readParameterStruct<DetectorNodeParameters>(private_nh)),
      detector_(DetectorModel::fromYamlFile(params_.model.empty() ? defaultModelFile()
                                                                  : callerPath(params_.model)),
                params_),
      transport_(nh),
      diagnostics_(nh, private_nh),
      tracker_(params_) {
  ros::NodeHandle handle(nh);
  mask_publisher_ = handle.advertise<sensor_msgs::Image>("mask", 5);
  detections_publisher_ = handle.advertise<DetectedObjects>("detections", 5);
  overlay_publisher_ = image_transport::ImageTransport(private_nh).advertise("overlay", 1);
  diagnostics_.setHardwareID("edge_mcl");
  diagnostics_.add("detection", this, &DetectorNode::diagnose);
  ROS_INFO("%s: the network takes %.0f ms for an image", detector_.model().name.c_str(),
           detector_.times().total());
  using Callback = boost::function<void(const sensor_msgs::ImageConstPtr&)>;
  image_subscriber_.subscribe(
      nh, &transport_, "image", 1, params_.image_transport,
      Callback([this](const sensor_msgs::ImageConstPtr& m) { receive(m); }));
  network_ = std::thread([this] { runNetwork(); });
  worker_ = std::thread([this] { work(); });
}

DetectorNode::~DetectorNode() {
  image_subscriber_.shutdown();
  {
    const std::scoped_lock lock(input_mutex_, job_mutex_);
    running_ = false;
  }
  input_ready_.notify_all();
  job_changed_.notify_all();
  if (worker_.joinable()) worker_.join();
  if (network_.joinable()) network_.join();
}

void DetectorNode::receive(const sensor_msgs::ImageConstPtr& message) {
  const std::lock_guard<std::mutex> lock(input_mutex_);
  newest_ = message;
  input_ready_.notify_one();
}

void DetectorNode::work() {
  while (running_) {
    sensor_msgs::ImageConstPtr message;
    {
      std::unique_lock<std::mutex> lock(input_mutex_);
      // The thread wakes up without an image, too, so that diagnostics are published.
      input_ready_.wait_for(lock, std::chrono::milliseconds(500),
                            [&] { return !running_ || newest_; });
      message.swap(newest_);
    }
    if (!running_) return;
    if (diagnostics_pace_.isDue(diagnostics_.getPeriod())) diagnostics_.force_update();
    if (!message) continue;
    try {
      handle(message);
    } catch (const std::exception& e) {
      ROS_WARN_THROTTLE(5, "%s", e.what());
      const std::lock_guard<std::mutex> lock(figures_mutex_);
      problem_ = e.what();
    }
  }
}

void DetectorNode::handle(const sensor_msgs::ImageConstPtr& message) {
  cv::Mat image = fromMessage(message, "image");
  image = toEightBits(image);
  if (message->header.stamp.isZero())
    throw InputError("image: it has no stamp, so a mask could not be matched to it");
  const double time = message->header.stamp.toSec();
  const ros::WallTime begin = ros::WallTime::now();
  bool anew = false;
  {
    const std::lock_guard<std::mutex> lock(tracker_mutex_);
    anew = tracker_.advance(image, time);
  }
  const double tracking_ms = (ros::WallTime::now() - begin).toSec() * 1000;
  offer(image, time, anew);
  publish(message, image);
  const std::lock_guard<std::mutex> lock(figures_mutex_);
  tracking_ms_ = tracking_ms;
  ++images_;
  problem_.clear();
}

void DetectorNode::offer(const cv::Mat& image, double time, bool anew) {
  std::unique_lock<std::mutex> lock(job_mutex_);
  const bool wait = anew || params_.every_image;
  if (busy_ && !wait) return;
  if (wait) job_changed_.wait(lock, [&] { return !running_ || !busy_; });
  // The rate is limited by stamps and not by a clock, because a bag may be played at any speed.
  // When the stamps go back, the network runs at once.
  const double since = time - started_;
  const bool due =
      wait || params_.max_rate <= 0 || since < 0 || since >= 1 / params_.max_rate - 1e-3;
  if (!running_ || !due) return;
  {
    const std::lock_guard<std::mutex> tracker_lock(tracker_mutex_);
    tracker_.hold();
  }
  job_ = Job{image.clone(), time};
  busy_ = true;
  started_ = time;
  job_changed_.notify_all();
  if (wait) job_changed_.wait(lock, [&] { return !running_ || !busy_; });
}

void DetectorNode::runNetwork() {
  // On Linux every thread has its own niceness.
  if (setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), params_.niceness) != 0)
    ROS_WARN("niceness %d cannot be set", params_.niceness);
  while (true) {
    Job job;
    {
      std::unique_lock<std::mutex> lock(job_mutex_);
      job_changed_.wait(lock, [&] { return !running_ || job_; });
      if (!running_) return;
      job = std::move(*job_);
      job_.reset();
    }
    std::string problem;
    try {
      const Detections found = detector_.detect(job.image);
      const std::lock_guard<std::mutex> lock(tracker_mutex_);
      if (!tracker_.confirm(job.time, found))
        problem =
            "the clock jumped back or the size of the images changed, so a result of the network "
            "is not used";
    } catch (const std::exception& e) {
      problem = e.what();
    }
    if (!problem.empty()) ROS_WARN_THROTTLE(5, "%s", problem.c_str());
    {
      const std::lock_guard<std::mutex> lock(figures_mutex_);
      network_times_ = detector_.times();
      ++runs_shown_;
      network_problem_ = problem;
    }
    const std::lock_guard<std::mutex> lock(job_mutex_);
    busy_ = false;
    job_changed_.notify_all();
  }
}

void DetectorNode::publish(const sensor_msgs::ImageConstPtr& message, const cv::Mat& image) {
  Detections objects;
  cv::Mat mask;
  {
    const std::lock_guard<std::mutex> lock(tracker_mutex_);
    objects = tracker_.objects();
    mask = tracker_.mask();
  }
  mask_publisher_.publish(toImage(mask, "mono8", message->header.stamp, message->header.frame_id));
  const std::vector<std::string>& classes = detector_.model().classes;
  DetectedObjects list;
  list.header = message->header;
  for (const Detection& d : objects) {
    DetectedObject object;
    object.class_name = classes.at(static_cast<size_t>(d.class_id));
    object.score = d.score;
    object.track_id = d.track_id;
    object.age = static_cast<float>(d.age);
    object.x = d.box.x;
    object.y = d.box.y;
    object.width = d.box.width;
    object.height = d.box.height;
    list.objects.push_back(object);
  }
  detections_publisher_.publish(list);
  if (overlay_publisher_.getNumSubscribers() > 0)
    overlay_publisher_.publish(toImage(drawDetections(image, objects, classes), "bgr8",
                                       message->header.stamp, message->header.frame_id));
  const std::lock_guard<std::mutex> lock(figures_mutex_);
  objects_ = objects.size();
}

void DetectorNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::lock_guard<std::mutex> lock(figures_mutex_);
  const ros::WallTime now = ros::WallTime::now();
  const double seconds = std::max(1e-3, (now - diagnosed_at_).toSec());
  using diagnostic_msgs::DiagnosticStatus;
  if (!network_problem_.empty())
    status.summary(DiagnosticStatus::WARN, network_problem_);
  else if (!problem_.empty())
    status.summary(DiagnosticStatus::WARN, problem_);
  else if (images_ == images_before_)
    status.summary(DiagnosticStatus::WARN, "no images");
  else
    status.summary(DiagnosticStatus::OK, "masks go out");
  status.add("model", detector_.model().name);
  status.add("images per second", static_cast<double>(images_ - images_before_) / seconds);
  status.add("network runs per second", static_cast<double>(runs_shown_ - runs_before_) / seconds);
  status.add("preparation ms", network_times_.preparation);
  status.add("network ms", network_times_.network);
  status.add("decoding ms", network_times_.decoding);
  status.add("tracking ms", tracking_ms_);
  status.add("objects", objects_);
  images_before_ = images_;
  runs_before_ = runs_shown_;
  diagnosed_at_ = now;
}

}  // namespace edge_mcl
