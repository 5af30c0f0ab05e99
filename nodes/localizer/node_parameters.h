/// Parameters of the localizer node, on top of those of the method.
#pragma once

#include <ros/node_handle.h>

#include <map>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/depth/depth_points.h"

namespace edge_mcl {

/// Names as amcl has them, where amcl has them.
struct NodeParameters {
  std::string model_file;
  std::string cameras;
  std::string global_frame_id = "map", odom_frame_id = "odom", base_frame_id = "base_link";
  std::string odometry = "tf";
  bool tf_broadcast = true;
  double transform_tolerance = 0.1;
  double transform_timeout = 0.2;
  double camera_timeout = 0.1;
  double camera_window = 0.02;
  bool use_masks = false;
  double mask_timeout = 0.2;
  std::string mask_policy = "unmasked";
  double depth_timeout = 0.1;
  double depth_window = kDepthWindow;
  bool global_start = false;
  bool search_in_background = true;
  bool use_imu = false;
  double imu_sigma = 0.02;
  int max_cloud_poses = 500;
  double save_pose_rate = 0.5;
  double update_min_d = 0, update_min_a = 0;
  double recovery_alpha_slow = 0, recovery_alpha_fast = 0;
  double initial_pose_x = 0, initial_pose_y = 0, initial_pose_z = 0;
  double initial_pose_roll = 0, initial_pose_pitch = 0, initial_pose_a = 0;
  double initial_cov_xx = 0.04, initial_cov_yy = 0.04, initial_cov_zz = 0.04;
  double initial_cov_rr = 0.004, initial_cov_pp = 0.004, initial_cov_aa = 0.01;
  bool has_initial_pose = false;  ///< set when any initial_pose_* is given

  template <class Visitor>
  void visit(Visitor&& v) {
    v("model_file", model_file, "", "the building: OBJ, PLY, DAE, IFC, ...");
    v("cameras", cameras, "",
      "names of the cameras, list or with commas; each has topics NAME/image, NAME/camera_info, "
      "NAME/mask, NAME/depth, NAME/depth/camera_info; empty: one camera, image, camera_info, ...");
    v("global_frame_id", global_frame_id, "", "frame of the model");
    v("odom_frame_id", odom_frame_id, "", "frame of the odometry");
    v("base_frame_id", base_frame_id, "", "frame of the robot");
    v("odometry", odometry, "", "tf, topic (nav_msgs/Odometry on odom) or none");
    v("tf_broadcast", tf_broadcast, "", "publish global frame -> odometry frame (or -> base)");
    v("transform_tolerance", transform_tolerance, "s", "how long a published transform holds");
    v("transform_timeout", transform_timeout, "s", "how long odometry is awaited for an image");
    v("camera_timeout", camera_timeout, "s",
      "how long the other cameras' images of a moment are awaited");
    v("camera_window", camera_window, "s", "images of several cameras this close are one moment");
    v("use_masks", use_masks, "", "wait for masks from a detector");
    v("mask_timeout", mask_timeout, "s", "how long the mask of an image is awaited");
    v("mask_policy", mask_policy, "",
      "without a mask in time: unmasked, skip_update, or use_last (turned with the camera)");
    v("depth_timeout", depth_timeout, "s", "how long the depth image of an image is awaited");
    v("depth_window", depth_window, "s", "an image and a depth image this close are one moment");
    v("global_start", global_start, "", "without an initial pose: look for it in the whole model");
    v("search_in_background", search_in_background, "",
      "use images while the pose is looked for; false: each search waits, images are dropped");
    v("use_imu", use_imu, "", "roll and pitch from the orientation in sensor_msgs/Imu on imu");
    v("imu_sigma", imu_sigma, "rad", "their standard deviation");
    v("max_cloud_poses", max_cloud_poses, "", "poses in particlecloud at most");
    v("save_pose_rate", save_pose_rate, "Hz",
      "how often the pose is stored in initial_pose_*; 0 = never");
    v("update_min_d", update_min_d, "m", "motion before images are used again; 0 = all are used");
    v("update_min_a", update_min_a, "rad", "likewise, rotation");
    v("recovery_alpha_slow", recovery_alpha_slow, "", "as filter/recovery_alpha_slow");
    v("recovery_alpha_fast", recovery_alpha_fast, "", "as filter/recovery_alpha_fast");
    v("initial_pose_x", initial_pose_x, "m",
      "where to begin; without any of these, wait for initialpose");
    v("initial_pose_y", initial_pose_y, "m", "");
    v("initial_pose_z", initial_pose_z, "m", "");
    v("initial_pose_roll", initial_pose_roll, "rad", "");
    v("initial_pose_pitch", initial_pose_pitch, "rad", "");
    v("initial_pose_a", initial_pose_a, "rad", "yaw");
    v("initial_cov_xx", initial_cov_xx, "m^2", "variances of the initial pose");
    v("initial_cov_yy", initial_cov_yy, "m^2", "");
    v("initial_cov_zz", initial_cov_zz, "m^2", "");
    v("initial_cov_rr", initial_cov_rr, "rad^2", "");
    v("initial_cov_pp", initial_cov_pp, "rad^2", "");
    v("initial_cov_aa", initial_cov_aa, "rad^2", "");
  }

  /// @throws ParameterError listing all faults.
  void validate() const;
  /// T_map_base.
  PoseGaussian initialPose() const;
  /// Empty name for the single camera.
  std::vector<std::string> cameraNames() const;
};

/// Both kinds of parameters from `name: value`, the method's as `group/name`.
/// @throws ParameterError listing every unknown name with the nearest known one, and every illegal
/// value.
void applyParameters(const std::map<std::string, std::string>& values, NodeParameters* node,
                     Parameters* method);

/// All parameters of a private namespace, as text.
std::map<std::string, std::string> readPrivateParameters(const ros::NodeHandle& private_nh);

/// Names that other libraries read from the same namespace.
bool isForeignParameter(const std::string& name);

}  // namespace edge_mcl
