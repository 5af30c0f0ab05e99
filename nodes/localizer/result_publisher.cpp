#include "edge_mcl/nodes/localizer/result_publisher.h"

#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <visualization_msgs/Marker.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

ResultPublisher::ResultPublisher(ros::NodeHandle nh, ros::NodeHandle private_nh,
                                 const NodeParameters& params, const FilterParameters& filter)
    : params_(params),
      filter_(filter),
      pose_(nh.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", 5, true)),
      cloud_(nh.advertise<geometry_msgs::PoseArray>("particlecloud", 2)),
      hypotheses_(nh.advertise<geometry_msgs::PoseArray>("hypotheses", 2)),
      status_(private_nh.advertise<Status>("status", 5, true)),
      model_(private_nh.advertise<visualization_msgs::Marker>("model", 1, true)),
      odometry_(nh.advertise<nav_msgs::Odometry>("odometry/filtered", 20)),
      path_(nh.advertise<nav_msgs::Path>("path", 1)),
      transport_(private_nh),
      overlay_(transport_.advertise("overlay", 1)) {}

void ResultPublisher::publish(const LiveResult& result, const LiveLocalizer& localizer,
                              const ResultContext& context) {
  if (!localizer.isInitialized()) {
    forgetPose();
  } else if (!result.late) {
    geometry_msgs::PoseWithCovarianceStamped pose;
    pose.header.stamp = context.stamp;
    pose.header.frame_id = params_.global_frame_id;
    pose.pose = toPoseMessage(result.estimate);
    pose_.publish(pose);
    publishTransform(result.estimate, context);
    publishPath(result, context.stamp);
    if (cloud_.getNumSubscribers() > 0) publishCloud(localizer, context.stamp);
    if (overlay_.getNumSubscribers() > 0) publishOverlay(result, localizer, context);
  }
  if (!result.clusters.empty() && hypotheses_.getNumSubscribers() > 0) {
    geometry_msgs::PoseArray hypotheses;
    hypotheses.header.stamp = context.stamp;
    hypotheses.header.frame_id = params_.global_frame_id;
    for (const PoseCluster& c : result.clusters) hypotheses.poses.push_back(toPoseMessage(c.pose));
    hypotheses_.publish(hypotheses);
  }
  publishStatus(result, localizer, context);
}

void ResultPublisher::publishTransform(const PoseGaussian& estimate, const ResultContext& context) {
  const bool to_base = params_.odometry == "none";
  if (!to_base && !context.odometry) return;
  Pose transform = estimate.mean;
  if (!to_base) {
    transform = normalized(estimate.mean * context.odometry->inverse());
    const std::lock_guard<std::mutex> lock(anchor_mutex_);
    anchor_ = Anchor{estimate, *context.odometry, context.stamp};
  }
  if (!params_.tf_broadcast) return;
  // The stamp is later than the image, as in amcl, so that the next odometry messages find a
  // transform.
  const ros::Time valid = context.stamp + ros::Duration(params_.transform_tolerance);
  broadcaster_.sendTransform(
      toTransformStamped(transform, valid, params_.global_frame_id,
                         to_base ? params_.base_frame_id : params_.odom_frame_id));
}

void ResultPublisher::forgetPose() {
  const std::lock_guard<std::mutex> lock(anchor_mutex_);
  anchor_.reset();
}

void ResultPublisher::publishPath(const LiveResult& result, const ros::Time& stamp) {
  constexpr double kStep = 0.05;   // m from pose to pose
  constexpr size_t kMost = 20000;  // poses, a flight of 1 km
  if (result.state != LocalizerState::kTracking) return;
  geometry_msgs::PoseStamped pose;
  pose.header.stamp = stamp;
  pose.header.frame_id = params_.global_frame_id;
  pose.pose = toPoseMessage(result.estimate.mean);
  std::vector<geometry_msgs::PoseStamped>& poses = path_so_far_.poses;
  // A bag that is played again begins a new path.
  if (!poses.empty() && stamp < poses.back().header.stamp) poses.clear();
  if (!poses.empty()) {
    const geometry_msgs::Point &a = poses.back().pose.position, &b = pose.pose.position;
    if (std::hypot(a.x - b.x, a.y - b.y, a.z - b.z) < kStep) return;
  }
  if (poses.size() >= kMost) poses.erase(poses.begin(), poses.begin() + kMost / 10);
  poses.push_back(pose);
  path_so_far_.header = pose.header;
  if (path_.getNumSubscribers() > 0) path_.publish(path_so_far_);
}

void ResultPublisher::publishCloud(const LiveLocalizer& localizer, const ros::Time& stamp) {
  const std::vector<Pose>& particles = localizer.filter().poses();
  const size_t most = static_cast<size_t>(params_.max_cloud_poses);
  const size_t step = std::max<size_t>(1, (particles.size() + most - 1) / most);
  geometry_msgs::PoseArray cloud;
  cloud.header.stamp = stamp;
  cloud.header.frame_id = params_.global_frame_id;
  for (size_t i = 0; i < particles.size(); i += step)
    cloud.poses.push_back(toPoseMessage(particles[i]));
  cloud_.publish(cloud);
}

namespace {

void addSearch(const LiveResult& result, const ResultContext& context, Status* status) {
  status->search_keyframes = static_cast<uint32_t>(result.search_keyframes);
  status->search_ms = static_cast<float>(result.search_ms);
  for (const PoseCluster& place : result.clusters)
    status->hypothesis_probabilities.push_back(static_cast<float>(place.probability));
  if (!result.next_view || result.clusters.empty()) return;
  const NextView& view = *result.next_view;
  status->next_view = {toPoseMessage(view.first), toPoseMessage(view.second)};
  const Pose camera =
      context.T_base_camera.empty() ? Pose::Identity() : context.T_base_camera.front();
  const NextView::Step step = view.stepFrom(result.clusters.front().pose, camera);
  status->next_view_shift.x = step.shift.x();
  status->next_view_shift.y = step.shift.y();
  status->next_view_shift.z = step.shift.z();
  status->next_view_turn = static_cast<float>(step.turn);
  status->next_view_difference = static_cast<float>(view.difference);
}

}  // namespace

void ResultPublisher::publishStatus(const LiveResult& result, const LiveLocalizer& localizer,
                                    const ResultContext& context) {
  Status status;
  status.header.stamp = context.stamp;
  status.header.frame_id = params_.global_frame_id;
  status.state = static_cast<uint8_t>(result.state);
  status.state_name = nameOf(result.state);
  status.problem = result.problem;
  status.backend = localizer.map().backend().name();
  const UpdateReport& r = result.report;
  const Eigen::Vector3d& origin = localizer.map().mesh().origin;
  status.map_origin.x = origin.x();
  status.map_origin.y = origin.y();
  status.map_origin.z = origin.z();
  status.probability = static_cast<float>(result.probability);
  status.contrast = static_cast<float>(r.contrast);
  status.focal_error = static_cast<float>(r.focal_error);
  status.centre_error = {static_cast<float>(r.centre_error.x()),
                         static_cast<float>(r.centre_error.y())};
  status.odometry_scale_error = static_cast<float>(result.odometry.scaleError());
  status.odometry_turn_rate = static_cast<float>(result.odometry.turnRate().norm());
  status.odometry_noise_factor = static_cast<float>(result.odometry.noiseFactor());
  status.effective_sample_size = static_cast<float>(r.effective_sample_size);
  status.match_ratio = static_cast<float>(result.match_ratio);
  status.evidence = static_cast<float>(r.evidence_per_line);
  status.visible_lines = static_cast<float>(r.visible_lines);
  status.visible_samples = static_cast<float>(r.visible_samples);
  status.depth_points = static_cast<float>(r.depth_points);
  status.depth_agreement = static_cast<float>(r.depth_agreement);
  status.masked_share = static_cast<float>(result.masked_share);
  const Vector6 variance = result.estimate.covariance.diagonal();
  status.position_std = static_cast<float>(std::sqrt(variance.head<3>().maxCoeff()));
  status.angle_std = static_cast<float>(std::sqrt(variance.tail<3>().maxCoeff()));
  status.edges_ms = static_cast<float>(result.image_times.edges);
  status.field_ms = static_cast<float>(result.image_times.field);
  status.table_ms = static_cast<float>(result.image_times.table);
  status.likelihood_ms = static_cast<float>(r.likelihood_ms);
  status.refinement_ms = static_cast<float>(r.refinement_ms);
  status.update_ms = static_cast<float>(context.update_ms);
  status.image_age = static_cast<float>((ros::Time::now() - context.stamp).toSec());
  status.mask_age = static_cast<float>(context.mask_age);
  addSearch(result, context, &status);
  status.images_received = context.images_received;
  status.images_dropped = context.images_dropped;
  status.updates = context.updates;
  status_.publish(status);
}

void ResultPublisher::publishOverlay(const LiveResult& result, const LiveLocalizer& localizer,
                                     const ResultContext& context) {
  if (result.images.empty() || context.T_base_camera.empty()) return;
  const cv::Mat picture = drawOverlay(localizer.map(), *result.images.front(),
                                      result.estimate.mean * context.T_base_camera.front());
  overlay_.publish(toImage(picture, "bgr8", context.stamp, params_.base_frame_id));
}

void ResultPublisher::publishModel(const LocalizationMap& map) {
  visualization_msgs::Marker lines;
  lines.header.frame_id = params_.global_frame_id;
  lines.ns = "model";
  lines.type = visualization_msgs::Marker::LINE_LIST;
  lines.pose.orientation.w = 1;
  lines.scale.x = 0.01;
  lines.color.r = 0.1f;
  lines.color.g = 0.7f;
  lines.color.b = 0.2f;
  lines.color.a = 1;
  for (const EdgeLine& line : map.edges().lines) {
    if (line.kind == EdgeKind::kContour) continue;
    for (const Eigen::Vector3f& end : {line.start, line.end}) {
      geometry_msgs::Point point;
      point.x = static_cast<double>(end.x());
      point.y = static_cast<double>(end.y());
      point.z = static_cast<double>(end.z());
      lines.points.push_back(point);
    }
  }
  model_.publish(lines);
}

void ResultPublisher::publishOdometry(const nav_msgs::Odometry& odometry) {
  std::optional<Anchor> anchor;
  {
    const std::lock_guard<std::mutex> lock(anchor_mutex_);
    anchor = anchor_;
  }
  if (!anchor) return;
  nav_msgs::Odometry in_map = odometry;
  in_map.header.frame_id = params_.global_frame_id;
  try {
    const Pose step = anchor->odometry.inverse() * fromMessage(odometry.pose.pose, "odometry");
    const double since = std::abs((odometry.header.stamp - anchor->stamp).toSec());
    in_map.pose = toPoseMessage(
        moved(anchor->estimate, step, odometryNoise(filter_, normalized(step), since)));
  } catch (const InputError&) {
    return;  // the localizer reports this fault
  }
  odometry_.publish(in_map);
}

}  // namespace edge_mcl
