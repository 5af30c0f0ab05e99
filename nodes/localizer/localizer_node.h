/// The localizer behind ROS topics, tf and services; used by the node and by the nodelet.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <dynamic_reconfigure/server.h>
#include <edge_mcl/LocalizerConfig.h>
#include <edge_mcl/SetPose.h>
#include <edge_mcl/UseFile.h>
#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <std_srvs/Empty.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/nodes/common/wall_pace.h"
#include "edge_mcl/nodes/localizer/localizer_diagnostics.h"
#include "edge_mcl/nodes/localizer/moment_queue.h"
#include "edge_mcl/nodes/localizer/moment_reader.h"
#include "edge_mcl/nodes/localizer/object_publisher.h"
#include "edge_mcl/nodes/localizer/result_publisher.h"

namespace edge_mcl {

class LocalizerNode {
 public:
  /// Reads parameters and model, subscribes, and starts to work on images in a thread of its own.
  /// @throws ParameterError, InputError
  LocalizerNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);
  ~LocalizerNode();
  LocalizerNode(const LocalizerNode&) = delete;
  LocalizerNode& operator=(const LocalizerNode&) = delete;

 private:
  void subscribe();
  void receiveOdometry(const nav_msgs::OdometryConstPtr& odometry);
  void receiveInitialPose(const geometry_msgs::PoseWithCovarianceStampedConstPtr& message);
  std::string setPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  bool reloadModel(UseFile::Request& request, UseFile::Response& response);
  bool saveParticles(UseFile::Request& request, UseFile::Response& response);
  bool loadParticles(UseFile::Request& request, UseFile::Response& response);
  void savePose();
  /// Tells once when no image comes.
  void warnOfSilence();
  /// Two publishers of one transform make it jump.
  void warnOfOtherTransform();
  void offerAdjustment();
  /// What diagnostics tell now.
  LocalizerFacts facts();

  void work();
  void process(const Moment& moment);

  ros::NodeHandle nh_, private_nh_;
  NodeParameters params_;
  Parameters method_;
  std::unique_ptr<ResultPublisher> publisher_;
  std::unique_ptr<ObjectPublisher> objects_;  // with masks by depth
  std::unique_ptr<MomentQueue> queue_;
  std::unique_ptr<MomentReader> reader_;

  std::mutex localizer_mutex_;  // guards what the worker and services share
  std::unique_ptr<LiveLocalizer> localizer_;
  bool force_update_ = false;
  uint32_t updates_ = 0;
  bool is_transform_checked_ = false, is_silence_told_ = false;
  const ros::WallTime started_ = ros::WallTime::now();
  std::optional<UpReading> last_up_;  // of the newest image that had one
  LocalizerFacts facts_;              // of the newest image
  ros::WallTime last_image_at_;

  std::vector<ros::Subscriber> subscribers_;
  std::vector<ros::ServiceServer> services_;
  ros::WallTimer save_timer_, diagnostics_timer_;
  diagnostic_updater::Updater diagnostics_;
  WallPace diagnostics_pace_;
  boost::recursive_mutex adjustment_mutex_;
  std::unique_ptr<dynamic_reconfigure::Server<LocalizerConfig>> adjustment_;
  std::atomic<bool> running_{true};
  std::thread worker_;
};

}  // namespace edge_mcl
