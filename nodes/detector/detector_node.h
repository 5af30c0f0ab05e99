/// Publishes a mask of the objects that are not in the map, for every image.
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
#include "edge_mcl/nodes/messages/image_subscriber.h"

namespace edge_mcl {

/// Parameters of the detector node. The functions of parameter_struct.h work with them.
struct DetectorNodeParameters : DetectorParameters {
  std::string model;
  std::string image_transport = "raw";
  double max_rate = 0;
  bool every_image = false;
  int niceness = 5;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("model", model, "", anyValue(),
      "YAML file that describes a network; empty: the network of this package");
    v("image_transport", image_transport, "", anyValue(),
      "transport of the images: raw, compressed, or another plugin of image_transport");
    v("max_rate", max_rate, "Hz", notNegative(),
      "largest rate at which the network runs, by the stamps of the images; 0 = no limit");
    v("every_image", every_image, "", anyValue(),
      "each mask waits until the network has run on its own image");
    v("niceness", niceness, "", from(0, 19),
      "niceness of the network's thread; 0 = as other threads, 19 = it uses only idle time");
    DetectorParameters::visit(v);
  }
};

/// The detector node. It subscribes to `image` and always takes the newest image. For every image
/// that it takes it publishes `mask` and `detections`. A mask is mono8, with the stamp and frame of
/// its image. A pixel that is not zero is ignored by the localizer; all pixels are zero when no
/// object is found. `~overlay` is published when a node subscribes to it. Diagnostics are published
/// as well.
///
/// The network runs in a thread of its own, on the newest image whenever the network is free. Masks
/// do not wait for the network. Exceptions are the very first mask, and the first mask after the
/// stamps jumped back or the size of the images changed, because no object is known then. An image
/// gets no mask when it has no stamp, or when it is not newer than the last image and at most 1 s
/// older.
class DetectorNode {
 public:
  /// @throws ParameterError for a wrong parameter; InputError when the network cannot be loaded
  DetectorNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);
  ~DetectorNode();
  DetectorNode(const DetectorNode&) = delete;
  DetectorNode& operator=(const DetectorNode&) = delete;

 private:
  struct Job {  // an image for the network
    cv::Mat image;
    double time = 0;
  };
  void receive(const sensor_msgs::ImageConstPtr& message);
  void work();        // a thread: tracks objects and publishes masks
  void runNetwork();  // a thread: runs the network on the jobs
  void handle(const sensor_msgs::ImageConstPtr& message);
  /// Gives the image to the network if the network is free and its next run is due. @param anew
  /// true: no object is known before this image, so wait for the network.
  void offer(const cv::Mat& image, double time, bool anew);
  void publish(const sensor_msgs::ImageConstPtr& message, const cv::Mat& image);
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  DetectorNodeParameters params_;
  MaskDetector detector_;
  image_transport::ImageTransport transport_;
  ros::Publisher mask_publisher_, detections_publisher_;
  image_transport::Publisher overlay_publisher_;
  ImageSubscriber image_subscriber_;
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

  std::mutex figures_mutex_;  // guards the figures for the diagnostics
  DetectorTimes network_times_;
  double tracking_ms_ = 0;
  size_t images_ = 0, objects_ = 0, images_before_ = 0, runs_shown_ = 0, runs_before_ = 0;
  std::string problem_;          // fault of the newest image
  std::string network_problem_;  // fault of the network's last run, which is shown first
  ros::WallTime diagnosed_at_ = ros::WallTime::now();

  std::atomic<bool> running_{true};
  std::thread worker_, network_;
};

}  // namespace edge_mcl
