/// The localizer behind ROS topics, tf and services; used by the node and by the nodelet.
#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <dynamic_reconfigure/server.h>
#include <edge_mcl/LocalizerConfig.h>
#include <edge_mcl/SetPose.h>
#include <edge_mcl/UseFile.h>
#include <image_transport/image_transport.h>
#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Imu.h>
#include <std_srvs/Empty.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/nodes/common/patience.h"
#include "edge_mcl/nodes/common/wall_pace.h"
#include "edge_mcl/nodes/localizer/mask_matcher.h"
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
  /// One camera and what came from it.
  struct Camera {
    Camera(bool use_masks, double mask_timeout) : matcher(use_masks, mask_timeout) {}
    std::string name, origin;
    image_transport::Subscriber image_subscriber, mask_subscriber;
    ros::Subscriber info_subscriber;
    sensor_msgs::CameraInfoConstPtr info;
    MaskMatcher matcher;
    Patience patience;  // with its images, where another camera says the moment
    image_transport::Subscriber depth_subscriber;
    ros::Subscriber depth_info_subscriber;
    sensor_msgs::CameraInfoConstPtr depth_info;
    std::deque<sensor_msgs::ImageConstPtr> depths;  // newest last
    Patience depth_patience;
    // Of the mask that was used last, for mask_policy use_last.
    cv::Mat last_mask;
    ros::Time last_mask_at;
    std::optional<Eigen::Matrix3d> last_mask_rotation;  // R_odom_camera
  };
  struct Moment;

  void subscribe();
  void subscribeToCamera(size_t camera);
  void receiveImage(size_t camera, const sensor_msgs::ImageConstPtr& image);
  void receiveDepth(size_t camera, const sensor_msgs::ImageConstPtr& depth);
  void receiveOdometry(const nav_msgs::OdometryConstPtr& odometry);
  void receiveImu(const sensor_msgs::ImuConstPtr& message);
  void receiveInitialPose(const geometry_msgs::PoseWithCovarianceStampedConstPtr& message);
  std::string setPose(const geometry_msgs::PoseWithCovarianceStamped& message);
  bool reloadModel(UseFile::Request& request, UseFile::Response& response);
  bool saveParticles(UseFile::Request& request, UseFile::Response& response);
  bool loadParticles(UseFile::Request& request, UseFile::Response& response);
  void savePose();
  void offerAdjustment();
  void diagnose(diagnostic_updater::DiagnosticStatusWrapper& status);

  void work();
  std::optional<Moment> nextMoment();
  /// @param until s by the wall clock; for a mask it is its own timeout that counts.
  std::optional<MaskMatcher::Match> awaitImage(size_t camera, const ros::Time& stamp, double until,
                                               std::unique_lock<std::mutex>* lock);
  sensor_msgs::ImageConstPtr awaitDepth(size_t camera, const ros::Time& stamp,
                                        std::unique_lock<std::mutex>* lock);
  void process(const Moment& moment);
  std::optional<UpReading> upAt(const ros::Time& stamp, std::string* problem);
  std::optional<Pose> odometryAt(const ros::Time& stamp, std::string* problem);
  bool addView(const Moment& moment, size_t camera, const std::optional<Pose>& odometry,
               LiveInput* input, double* mask_age, std::string* problem);
  void addDepth(const Moment& moment, size_t camera, const std::optional<Pose>& odometry,
                LiveInput* input, double* mask_age, std::string* problem);
  /// T_base_frame at that time, or the newest where that time is not known (a fixed mounting).
  Pose mountingOf(const std_msgs::Header& header, const std::string& origin) const;
  cv::Mat maskFor(Camera* camera, const MaskMatcher::Match& match, const CameraModel& model,
                  const std::optional<Pose>& T_odom_camera, bool* skip, double* age);

  ros::NodeHandle nh_, private_nh_;
  NodeParameters params_;
  Parameters method_;
  image_transport::ImageTransport transport_;
  std::unique_ptr<ResultPublisher> publisher_;
  tf2_ros::Buffer tf_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  std::unique_ptr<tf2::BufferCore> odometry_buffer_;  // of the topic

  std::mutex input_mutex_;  // guards what callbacks write
  std::condition_variable input_ready_;
  std::vector<Camera> cameras_;
  std::deque<sensor_msgs::ImuConstPtr> imu_;  // newest last
  uint32_t images_received_ = 0;
  Patience odometry_patience_;
  ros::Time odometry_at_;  // stamp of the newest on the topic

  std::mutex localizer_mutex_;  // guards what the worker and services share
  std::unique_ptr<LiveLocalizer> localizer_;
  bool force_update_ = false;
  uint32_t updates_ = 0;
  LiveResult last_result_;
  double last_update_ms_ = 0;
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
