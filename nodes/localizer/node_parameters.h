/// Parameters of the localizer node, on top of those of the method.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/depth/depth_points.h"

namespace edge_mcl {

/// Where amcl has a parameter of the same meaning, the name is amcl's. Functions of
/// parameter_struct.h apply.
struct NodeParameters {
  std::string model_file;
  std::string cameras;
  std::string camera_file, camera_frame_id;
  std::string rectified = "auto";
  std::string image_transport = "raw", depth_transport = "raw";
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
    v("model_file", model_file, "", anyValue(), "model of the building: OBJ, PLY, DAE, IFC, ...");
    v("cameras", cameras, "", anyValue(),
      "names of the cameras, as a list or separated by commas; each has the topics NAME/image, "
      "NAME/camera_info, NAME/mask, NAME/depth, NAME/depth/camera_info; empty: one camera, whose "
      "topics have no prefix");
    v("camera_file", camera_file, "", anyValue(),
      "calibration files of the cameras, as a list or separated by commas; empty: the topic "
      "camera_info");
    v("camera_frame_id", camera_frame_id, "", anyValue(),
      "optical frames of the cameras, as a list or separated by commas; empty: the frame of each "
      "image");
    v("rectified", rectified, "", oneOf("auto|true|false"),
      "the images are rectified, so the matrix P of camera_info counts; auto = the topic has rect "
      "in "
      "its name");
    v("image_transport", image_transport, "", anyValue(),
      "transport of the images: raw, compressed, or another plugin of image_transport");
    v("depth_transport", depth_transport, "", anyValue(),
      "transport of the depth images: raw, compressedDepth, or another plugin");
    v("global_frame_id", global_frame_id, "", anyValue(), "frame of the model");
    v("odom_frame_id", odom_frame_id, "", anyValue(), "frame of the odometry");
    v("base_frame_id", base_frame_id, "", anyValue(), "frame of the robot");
    v("odometry", odometry, "", oneOf("tf|topic|none"),
      "source of odometry; topic = nav_msgs/Odometry on odom");
    v("tf_broadcast", tf_broadcast, "", anyValue(),
      "the transform global frame -> odometry frame (without odometry -> base) is published");
    v("transform_tolerance", transform_tolerance, "s", notNegative(),
      "time for which a published transform is valid");
    v("transform_timeout", transform_timeout, "s", notNegative(),
      "time for which an image waits for odometry");
    v("camera_timeout", camera_timeout, "s", notNegative(),
      "time for which an image waits for the images of the other cameras");
    v("camera_window", camera_window, "s", notNegative(),
      "images of several cameras belong together when their stamps differ by at most this");
    v("use_masks", use_masks, "", anyValue(), "an image waits for its mask from a detector");
    v("mask_timeout", mask_timeout, "s", notNegative(),
      "time for which an image waits for its mask");
    v("mask_policy", mask_policy, "", oneOf("unmasked|skip_update|use_last"),
      "what happens when no mask comes in time; use_last = the last mask, turned with the camera");
    v("depth_timeout", depth_timeout, "s", notNegative(),
      "time for which an image waits for its depth image");
    v("depth_window", depth_window, "s", notNegative(),
      "an image and a depth image belong together when their stamps differ by at most this");
    v("global_start", global_start, "", anyValue(),
      "without an initial pose, the pose is searched in the whole model");
    v("search_in_background", search_in_background, "", anyValue(),
      "images are used during a search; false: images that come during a search are dropped");
    v("use_imu", use_imu, "", anyValue(), "roll and pitch come from sensor_msgs/Imu on imu");
    v("imu_sigma", imu_sigma, "rad", positive(), "standard deviation of that roll and pitch");
    v("max_cloud_poses", max_cloud_poses, "", atLeast(1),
      "largest number of poses in particlecloud");
    v("save_pose_rate", save_pose_rate, "Hz", notNegative(),
      "rate at which the pose is stored in initial_pose_*; 0 = never");
    v("update_min_d", update_min_d, "m", notNegative(),
      "motion after which the next image is used; 0 = every image is used");
    v("update_min_a", update_min_a, "rad", notNegative(),
      "rotation after which the next image is used; 0 = every image is used");
    v("recovery_alpha_slow", recovery_alpha_slow, "", from(0, 1),
      "same as filter/recovery_alpha_slow");
    v("recovery_alpha_fast", recovery_alpha_fast, "", from(0, 1),
      "same as filter/recovery_alpha_fast");
    v("initial_pose_x", initial_pose_x, "m", anyValue(),
      "initial position; when no initial_pose_* is set, the node waits for initialpose");
    v("initial_pose_y", initial_pose_y, "m", anyValue(), "initial position");
    v("initial_pose_z", initial_pose_z, "m", anyValue(), "initial position");
    v("initial_pose_roll", initial_pose_roll, "rad", anyValue(), "initial roll");
    v("initial_pose_pitch", initial_pose_pitch, "rad", anyValue(), "initial pitch");
    v("initial_pose_a", initial_pose_a, "rad", anyValue(), "initial yaw");
    v("initial_cov_xx", initial_cov_xx, "m^2", notNegative(), "variance of the initial x");
    v("initial_cov_yy", initial_cov_yy, "m^2", notNegative(), "variance of the initial y");
    v("initial_cov_zz", initial_cov_zz, "m^2", notNegative(), "variance of the initial z");
    v("initial_cov_rr", initial_cov_rr, "rad^2", notNegative(), "variance of the initial roll");
    v("initial_cov_pp", initial_cov_pp, "rad^2", notNegative(), "variance of the initial pitch");
    v("initial_cov_aa", initial_cov_aa, "rad^2", notNegative(), "variance of the initial yaw");
  }

  /// Faults that ranges do not tell, one text each.
  std::vector<std::string> faults() const;
  /// T_map_base.
  PoseGaussian initialPose() const;
  /// The single camera has an empty name.
  std::vector<std::string> cameraNames() const;
  /// The entries of `camera_file` and `camera_frame_id`, one for each camera; empty: not given.
  std::vector<std::string> cameraFiles() const { return perCamera(camera_file); }
  std::vector<std::string> cameraFrames() const { return perCamera(camera_frame_id); }
  /// Whether images of a topic (after remapping) are rectified.
  bool isRectified(const std::string& topic) const;

 private:
  std::vector<std::string> perCamera(const std::string& list) const;
};

/// Sets the parameters of the node and those of the method (`group/name`) from `name: value`.
/// @throws ParameterError that lists every unknown name with the nearest known one and every
/// illegal value
void applyParameters(const std::map<std::string, std::string>& values, NodeParameters* node,
                     Parameters* method);

}  // namespace edge_mcl
