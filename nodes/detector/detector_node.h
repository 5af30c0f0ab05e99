/// Masks of what is not in the map, for every image.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <image_transport/image_transport.h>
#include <ros/node_handle.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "edge_mcl/detector/mask_detector.h"
#include "edge_mcl/detector/object_tracker.h"
#include "edge_mcl/nodes/common/wall_pace.h"

namespace edge_mcl {

struct DetectorNodeParameters : DetectorParameters {
  std::string model;  ///< YAML description of a network; empty: the one that comes with the package
  double max_rate = 0;       ///< runs of the network per second; 0: as fast as it can
  bool every_image = false;  ///< the mask waits for the network's run on its own image
  int niceness = 5;          ///< of the network's thread: 0 as all others, 19 only idle time

  template <class Visitor>
  void visit(Visitor&& v) {
    v("model", model);
    v("max_rate", max_rate);
    v("every_image", every_image);
    v("niceness", niceness);
    DetectorParameters::visit(v);
  }
  std::vector<std::string> faults() const;
};

/// Subscribes to `image`; publishes `mask` (mono8, non-zero: ignore; stamp and frame of its image,
/// all zero when nothing is found) and `detections` for every image it takes, the newest first;
/// `~overlay` when somebody looks; diagnostics.
///
/// The network runs in a thread of its own, on the newest image whenever it is free. Masks do not
/// wait for it, but the very first and the first after a jump back or a change of size, as nothing
/// is known before. An image without a stamp, or one that comes up to a second late, gets no mask.
class DetectorNode {
 public:
  /// @throws ParameterError; InputError when the network cannot be loaded.
  DetectorNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);
  ~DetectorNode();
  DetectorNode(const DetectorNode&) = delete;
  DetectorNode& operator=(const DetectorNode&) = delete;

 private:
  struct Job {  // for the network
    cv::Mat image;
    double time = 0;
  };
  void receive(const sensor_msgs::ImageConstPtr& message);
  void work();        // tracks and publishes
  void runNetwork();  // on the jobs
  void handle(const sensor_msgs::ImageConstPtr& message);
  /// @param anew nothing is known before this image: wait for the network.
  void offer(const cv::Mat& image, double time, bool anew);
  void publish(const sensor_msgs::ImageConstPtr& message, const cv::Mat& image);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  DetectorNodeParameters params_;
  MaskDetector detector_;
  image_transport::ImageTransport transport_;
  ros::Publisher mask_publisher_, detections_publisher_;
  image_transport::Publisher overlay_publisher_;
  image_transport::Subscriber image_subscriber_;
  diagnostic_updater::Updater diagnostics_;
  WallPace diagnostics_pace_;

  std::mutex input_mutex_;
  std::condition_variable input_ready_;
  sensor_msgs::ImageConstPtr newest_;

  std::mutex job_mutex_;
  std::condition_variable job_changed_;
  std::optional<Job> job_;
  bool busy_ = false;
  double started_ = 0;  // stamp of the image that the network last took

  std::mutex tracker_mutex_;
  ObjectTracker tracker_;

  std::mutex figures_mutex_;  // for diagnostics
  DetectorTimes network_times_;
  double tracking_ms_ = 0;
  size_t images_ = 0, objects_ = 0, images_before_ = 0, runs_shown_ = 0, runs_before_ = 0;
  std::string problem_;          // with the newest image
  std::string network_problem_;  // of its last run, shown first
  ros::WallTime diagnosed_at_ = ros::WallTime::now();

  std::atomic<bool> running_{true};
  std::thread worker_, network_;
};

}  // namespace edge_mcl
