/// Publishes the results of the localizer node.
#pragma once

#include <edge_mcl/Status.h>
#include <image_transport/image_transport.h>
#include <nav_msgs/Odometry.h>
#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <mutex>
#include <optional>
#include <string>

#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/nodes/localizer/node_parameters.h"

namespace edge_mcl {

/// Data of the node that are published together with a result.
struct ResultContext {
  ros::Time stamp;               ///< stamp of the image
  std::optional<Pose> odometry;  ///< T_odom_base at the time of the image
  double mask_age = -1;          ///< age of the mask, s; negative: no mask
  uint32_t images_received = 0, images_dropped = 0, updates = 0;
  double update_ms = 0;
  std::vector<Pose> T_base_camera;  ///< extrinsics of the cameras of the result's images
};

/// Publishes poses, particles, status, overlay, model and transform.
class ResultPublisher {
 public:
  ResultPublisher(ros::NodeHandle nh, ros::NodeHandle private_nh, const NodeParameters& params,
                  const FilterParameters& filter);

  /// Publishes a result. Without a pose, only status and hypotheses are published.
  void publish(const LiveResult& result, const LiveLocalizer& localizer,
               const ResultContext& context);
  /// Changes the parameters that may change while the node runs. Must not be called during
  /// publish().
  void adjust(double transform_tolerance, int max_cloud_poses) {
    params_.transform_tolerance = transform_tolerance;
    params_.max_cloud_poses = max_cloud_poses;
  }
  /// Publishes the lines of the model, latched.
  void publishModel(const LocalizationMap& map);
  /// Publishes the pose between images: odometry, carried over into the map. Its covariance grows
  /// with the time since the image. Publishes nothing while there is no pose.
  void publishOdometry(const nav_msgs::Odometry& odometry);
  /// Forgets the pose. Odometry is not carried over until there is a new pose.
  void forgetPose();

 private:
  void publishTransform(const PoseGaussian& estimate, const ResultContext& context);
  /// Adds a trusted pose to the path.
  void publishPath(const LiveResult& result, const ros::Time& stamp);
  void publishCloud(const LiveLocalizer& localizer, const ros::Time& stamp);
  void publishStatus(const LiveResult& result, const LiveLocalizer& localizer,
                     const ResultContext& context);
  void publishOverlay(const LiveResult& result, const LiveLocalizer& localizer,
                      const ResultContext& context);

  /// Pose at the last image, from which odometry goes on.
  struct Anchor {
    PoseGaussian estimate;  // T_map_base
    Pose odometry;          // T_odom_base at the same time
    ros::Time stamp;
  };

  NodeParameters params_;
  FilterParameters filter_;  // holds the noise of odometry
  ros::Publisher pose_, cloud_, hypotheses_, status_, model_, odometry_, path_;
  nav_msgs::Path path_so_far_;
  image_transport::ImageTransport transport_;
  image_transport::Publisher overlay_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::mutex anchor_mutex_;  // odometry arrives in another thread than results
  std::optional<Anchor> anchor_;
};

}  // namespace edge_mcl
