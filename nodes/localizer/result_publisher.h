/// What the localizer node tells others.
#pragma once

#include <edge_mcl/Status.h>
#include <image_transport/image_transport.h>
#include <nav_msgs/Odometry.h>
#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <mutex>
#include <optional>
#include <string>

#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/nodes/localizer/node_parameters.h"

namespace edge_mcl {

/// What goes with a result.
struct ResultContext {
  ros::Time stamp;               ///< of the image
  std::optional<Pose> odometry;  ///< T_odom_base at that time
  double mask_age = -1;          ///< s; negative: no mask
  uint32_t images_received = 0, images_dropped = 0, updates = 0;
  double update_ms = 0;
  std::vector<Pose> T_base_camera;  ///< of each of the result's images
};

class ResultPublisher {
 public:
  ResultPublisher(ros::NodeHandle nh, ros::NodeHandle private_nh, const NodeParameters& params,
                  const FilterParameters& filter);

  void publish(const LiveResult& result, const LiveLocalizer& localizer,
               const ResultContext& context);
  /// Changes what may change while it runs; not while publish() does.
  void adjust(double transform_tolerance, int max_cloud_poses) {
    params_.transform_tolerance = transform_tolerance;
    params_.max_cloud_poses = max_cloud_poses;
  }
  /// The model's lines, latched.
  void publishModel(const LocalizationMap& map);
  /// The pose between images: odometry carried over into the map, the less certain the longer ago
  /// the image was; nothing while there is no pose.
  void publishOdometry(const nav_msgs::Odometry& odometry);
  /// There is no pose any more: odometry is not carried over until there is one again.
  void forgetPose();

 private:
  void publishTransform(const PoseGaussian& estimate, const ResultContext& context);
  void publishCloud(const LiveLocalizer& localizer, const ros::Time& stamp);
  void publishStatus(const LiveResult& result, const LiveLocalizer& localizer,
                     const ResultContext& context);
  void publishOverlay(const LiveResult& result, const LiveLocalizer& localizer,
                      const ResultContext& context);

  /// What odometry goes on from.
  struct Anchor {
    PoseGaussian estimate;  // T_map_base
    Pose odometry;          // T_odom_base then
    ros::Time stamp;
  };

  NodeParameters params_;
  FilterParameters filter_;  // how odometry errs
  ros::Publisher pose_, cloud_, hypotheses_, status_, model_, odometry_;
  image_transport::ImageTransport transport_;
  image_transport::Publisher overlay_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::mutex anchor_mutex_;  // odometry comes in another thread than results
  std::optional<Anchor> anchor_;
};

}  // namespace edge_mcl
