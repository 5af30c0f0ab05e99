#include "edge_mcl/nodes/localizer/localizer_node.h"

#include <ros/console.h>

#include <chrono>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/map_factory.h"
#include "edge_mcl/nodes/common/caller_path.h"
#include "edge_mcl/nodes/common/private_parameters.h"
#include "edge_mcl/nodes/localizer/particle_file.h"
#include "edge_mcl/nodes/localizer/planar_pose.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

namespace {

std::shared_ptr<const LocalizationMap> loadMap(const std::string& file, const Parameters& method) {
  std::shared_ptr<const LocalizationMap> map = makeMap(file, method);
  for (const std::string& warning : map->mesh().report.warnings)
    ROS_WARN("%s: %s", file.c_str(), warning.c_str());
  return map;
}

/// Pairs of the same name in cfg/Localizer.cfg and in `tracking`.
template <class F>
void forEachAdjustable(LocalizerConfig* config, TrackingParameters* tracking, F f) {
  f(config->min_probability, tracking->min_probability);
  f(config->keep_probability, tracking->keep_probability);
  f(config->lost_probability, tracking->lost_probability);
  f(config->min_match_ratio, tracking->min_match_ratio);
  f(config->min_evidence, tracking->min_evidence);
  f(config->min_depth_agreement, tracking->min_depth_agreement);
  f(config->lost_after, tracking->lost_after);
  f(config->min_visible_samples, tracking->min_visible_samples);
  f(config->min_edge_pixels, tracking->min_edge_pixels);
  f(config->max_masked_share, tracking->max_masked_share);
  f(config->converged_std_position, tracking->converged_std_position);
  f(config->converged_std_angle_deg, tracking->converged_std_angle_deg);
  f(config->update_min_d, tracking->update_min_d);
}

}  // namespace

LocalizerNode::LocalizerNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh)
    : nh_(nh), private_nh_(private_nh), diagnostics_(nh, private_nh) {
  applyParameters(readPrivateParameters(private_nh_), &params_, &method_);
  params_.model_file = callerPath(params_.model_file);
  const auto map = loadMap(params_.model_file, method_);
  localizer_ = std::make_unique<LiveLocalizer>(map, params_.search_in_background);
  if (method_.search.recover || params_.global_start) localizer_->prepareSearch();
  if (params_.has_initial_pose) localizer_->setPose(params_.initialPose());
  publisher_ = std::make_unique<ResultPublisher>(nh_, private_nh_, params_, method_.filter);
  publisher_->publishModel(*map);
  if (method_.tracking.mask_by_depth)
    objects_ = std::make_unique<ObjectPublisher>(nh_, private_nh_, params_.global_frame_id);
  ROS_INFO("%s: %zu lines; %d particles; %s", params_.model_file.c_str(), map->edges().lines.size(),
           method_.filter.particles, map->backend().name().c_str());
  if (!params_.has_initial_pose && params_.global_start) localizer_->searchEverywhere();
  if (!params_.has_initial_pose && !params_.global_start)
    ROS_INFO("waiting for an initial pose on initialpose, or for a call of global_localization");
  const Cues needed = neededImages(method_);
  queue_ = std::make_unique<MomentQueue>(nh_, params_, needed);
  reader_ = std::make_unique<MomentReader>(nh_, params_, needed, queue_->cameraCount());
  diagnostics_.setHardwareID("edge_mcl");
  using Task = void (*)(const LocalizerFacts&, diagnostic_updater::DiagnosticStatusWrapper*);
  const std::pair<const char*, Task> tasks[] = {
      {"localization", diagnosePose}, {"images", diagnoseImages}, {"motion", diagnoseMotion}};
  for (const auto& [name, task] : tasks)
    diagnostics_.add(name, [this, tell = task](diagnostic_updater::DiagnosticStatusWrapper& s) {
      tell(facts(), &s);
    });
  offerAdjustment();
  subscribe();
  worker_ = std::thread([this] { work(); });
}

LocalizerNode::~LocalizerNode() {
  running_ = false;
  reader_->stop();
  queue_->stop();
  if (worker_.joinable()) worker_.join();
}

void LocalizerNode::offerAdjustment() {
  // The server leaves values of its own on the parameter server, so it has its own namespace.
  adjustment_ = std::make_unique<dynamic_reconfigure::Server<LocalizerConfig>>(
      adjustment_mutex_, ros::NodeHandle(private_nh_, "adjust"));
  LocalizerConfig now;
  TrackingParameters tracking = localizer_->tracking();
  forEachAdjustable(&now, &tracking, [](auto& offered, const auto& used) { offered = used; });
  now.update_min_a = tracking.update_min_a_deg * M_PI / 180;
  now.transform_tolerance = params_.transform_tolerance;
  now.max_cloud_poses = params_.max_cloud_poses;
  {
    const boost::recursive_mutex::scoped_lock lock(adjustment_mutex_);
    adjustment_->updateConfig(now);
  }
  adjustment_->setCallback([this](LocalizerConfig& wanted, uint32_t) {
    const std::lock_guard<std::mutex> lock(localizer_mutex_);
    TrackingParameters adjusted = localizer_->tracking();
    forEachAdjustable(&wanted, &adjusted, [](const auto& offered, auto& used) { used = offered; });
    adjusted.update_min_a_deg = wanted.update_min_a * 180 / M_PI;
    localizer_->setTracking(adjusted);
    publisher_->adjust(wanted.transform_tolerance, wanted.max_cloud_poses);
  });
}

void LocalizerNode::subscribe() {
  // odom is published in the map at its own rate, even when the localizer takes odometry from tf.
  subscribers_.push_back(nh_.subscribe("odom", 50, &LocalizerNode::receiveOdometry, this));
  subscribers_.push_back(nh_.subscribe("initialpose", 2, &LocalizerNode::receiveInitialPose, this));
  services_.push_back(nh_.advertiseService<std_srvs::Empty::Request, std_srvs::Empty::Response>(
      "request_nomotion_update", [this](std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
        const std::lock_guard<std::mutex> lock(localizer_mutex_);
        return force_update_ = true;
      }));
  services_.push_back(nh_.advertiseService<std_srvs::Empty::Request, std_srvs::Empty::Response>(
      "global_localization", [this](std_srvs::Empty::Request&, std_srvs::Empty::Response&) {
        const std::lock_guard<std::mutex> lock(localizer_mutex_);
        localizer_->searchEverywhere();
        publisher_->forgetPose();
        return true;
      }));
  services_.push_back(private_nh_.advertiseService<SetPose::Request, SetPose::Response>(
      "set_pose", [this](SetPose::Request& request, SetPose::Response& response) {
        response.message = setPose(request.pose);
        response.success = response.message.empty();
        return true;
      }));
  services_.push_back(
      private_nh_.advertiseService("reload_model", &LocalizerNode::reloadModel, this));
  services_.push_back(
      private_nh_.advertiseService("save_particles", &LocalizerNode::saveParticles, this));
  services_.push_back(
      private_nh_.advertiseService("load_particles", &LocalizerNode::loadParticles, this));
  if (params_.save_pose_rate > 0)
    save_timer_ = nh_.createWallTimer(ros::WallDuration(1 / params_.save_pose_rate),
                                      [this](const ros::WallTimerEvent&) { savePose(); });
  diagnostics_timer_ =
      nh_.createWallTimer(ros::WallDuration(0.1), [this](const ros::WallTimerEvent&) {
        warnOfSilence();
        if (diagnostics_pace_.isDue(diagnostics_.getPeriod())) diagnostics_.force_update();
      });
}

void LocalizerNode::receiveOdometry(const nav_msgs::OdometryConstPtr& odometry) {
  try {
    reader_->addOdometry(*odometry);
  } catch (const InputError& e) {
    ROS_WARN_THROTTLE(5, "%s, left out", e.what());
    return;
  }
  publisher_->publishOdometry(*odometry);
}

void LocalizerNode::receiveInitialPose(
    const geometry_msgs::PoseWithCovarianceStampedConstPtr& message) {
  const std::string problem = setPose(*message);
  if (!problem.empty()) ROS_WARN("initialpose is not used: %s", problem.c_str());
}

std::string LocalizerNode::setPose(const geometry_msgs::PoseWithCovarianceStamped& message) {
  try {
    const bool is_planar = isPlanar(message.pose);
    PoseGaussian pose = fromMessage(message.pose, "initial pose");
    const std::string frame = frameName(message.header.frame_id);
    if (!frame.empty() && frame != params_.global_frame_id) {
      const tf2_ros::Buffer& transforms = reader_->transforms();
      std::string why;
      if (!transforms.canTransform(params_.global_frame_id, frame, ros::Time(0), &why))
        throw InputError("its frame '" + frame + "' is not known in " + params_.global_frame_id +
                         ": " + why);
      const Pose T_map_frame = fromMessage(
          transforms.lookupTransform(params_.global_frame_id, frame, ros::Time(0)).transform,
          frame);
      pose.mean = T_map_frame * pose.mean;  // the covariance stays: it is in the robot's axes
    }
    const std::lock_guard<std::mutex> lock(localizer_mutex_);
    if (is_planar) {
      PlanarContext context;
      constexpr double kKeepsHeight = 5;  // s, in which a robot seldom climbs or descends much
      context.last = localizer_->trackedPose(kKeepsHeight);
      context.up = last_up_;
      context.is_camera_base = reader_->isCameraBase();
      geometry_msgs::PoseWithCovariance in_map = message.pose;
      in_map.pose = toPoseMessage(pose.mean);
      pose = completePlanar(in_map, localizer_->map(), context);
    }
    if (is_planar)
      localizer_->searchAround(pose);
    else
      localizer_->setPose(pose);
    ROS_INFO("initial pose: %.2f %.2f %.2f m%s", pose.mean.translation().x(),
             pose.mean.translation().y(), pose.mean.translation().z(),
             is_planar ? "; it is searched for there, since height and tilt were not given" : "");
    const std::string hint = hintBeside(localizer_->map().mesh(), pose.mean.translation());
    if (!hint.empty()) ROS_WARN("initial pose: %s", hint.c_str());
    return "";
  } catch (const std::exception& e) {
    return e.what();
  }
}

bool LocalizerNode::reloadModel(UseFile::Request& request, UseFile::Response& response) {
  const std::string file = request.file.empty() ? params_.model_file : request.file;
  try {
    const auto map = loadMap(file, method_);
    const std::lock_guard<std::mutex> lock(localizer_mutex_);
    localizer_->setMap(map);
    if (method_.search.recover) localizer_->prepareSearch();
    params_.model_file = file;
    publisher_->publishModel(*map);
    response.success = true;
    response.message = file + ": " + std::to_string(map->edges().lines.size()) + " lines";
  } catch (const std::exception& e) {
    response.success = false;
    response.message = std::string(e.what()) + "; the model in use is kept";
    ROS_WARN("reload_model: %s", response.message.c_str());
  }
  return true;
}

bool LocalizerNode::saveParticles(UseFile::Request& request, UseFile::Response& response) {
  ParticleSet particles;
  {
    const std::lock_guard<std::mutex> lock(localizer_mutex_);
    if (localizer_->isInitialized())
      particles = {localizer_->filter().poses(), localizer_->filter().logWeights()};
  }
  try {
    if (particles.poses.empty()) throw InputError("there are no particles yet");
    writeParticles(request.file, particles);
    response.success = true;
    response.message = std::to_string(particles.poses.size()) + " particles";
  } catch (const std::exception& e) {
    response.message = e.what();
  }
  return true;
}

bool LocalizerNode::loadParticles(UseFile::Request& request, UseFile::Response& response) {
  try {
    ParticleSet particles = readParticles(request.file);
    const size_t count = particles.poses.size();
    const std::lock_guard<std::mutex> lock(localizer_mutex_);
    localizer_->setParticles(std::move(particles.poses), std::move(particles.log_weights));
    response.success = true;
    response.message = std::to_string(count) + " particles";
  } catch (const std::exception& e) {
    response.message = e.what();
  }
  return true;
}

void LocalizerNode::work() {
  while (running_) {
    const std::optional<Moment> moment = queue_->next();
    if (!moment) continue;
    try {
      process(*moment);
    } catch (const std::exception& e) {
      ROS_ERROR_THROTTLE(5, "an image could not be used: %s", e.what());
    }
  }
}

void LocalizerNode::process(const Moment& moment) {
  const auto begin = std::chrono::steady_clock::now();
  MomentInput read = reader_->read(moment);
  LiveInput& input = read.input;
  ResultContext context;
  context.stamp = moment.stamp;
  context.odometry = input.odometry;
  context.mask_age = read.mask_age;
  warnOfOtherTransform();
  const std::lock_guard<std::mutex> lock(localizer_mutex_);
  input.force_update = force_update_;
  force_update_ = false;
  if (input.up) last_up_ = input.up;
  LiveResult result = localizer_->process(input);
  for (const size_t number : result.image_numbers)
    context.T_base_camera.push_back(input.images[number].T_base_camera);
  const bool nothing_usable = input.images.empty() && input.depths.empty();
  if (!read.problem.empty() && (result.problem.empty() || nothing_usable))
    result.problem = read.problem;
  if (result.updated) ++updates_;
  context.images_received = moment.received;
  context.images_dropped = moment.dropped;
  context.updates = updates_;
  context.update_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  if (result.restarted || result.is_told_once)
    ROS_WARN("%s", result.problem.c_str());
  else if (!result.problem.empty())
    ROS_WARN_THROTTLE(5, "%s: %s", nameOf(result.state), result.problem.c_str());
  if (objects_) objects_->publish(input, result, moment.stamp);
  publisher_->publish(result, *localizer_, context);
  last_image_at_ = ros::WallTime::now();
  facts_.update_ms = context.update_ms;
  facts_.images_received = context.images_received;
  facts_.images_dropped = context.images_dropped;
  facts_.mask_age = context.mask_age;
  facts_.has_odometry = input.odometry.has_value();
  facts_.wants_odometry = params_.odometry != "none";
  facts_.has_up = input.up.has_value();
  facts_.result = std::move(result);
  facts_.result.images.clear();  // diagnostics do not need them, and they are large
}

void LocalizerNode::warnOfOtherTransform() {
  if (is_transform_checked_ || !params_.tf_broadcast || updates_ > 0) return;
  is_transform_checked_ = true;
  const std::string& child =
      params_.odometry == "none" ? params_.base_frame_id : params_.odom_frame_id;
  if (reader_->transforms().canTransform(params_.global_frame_id, child, ros::Time(0)))
    ROS_WARN(
        "tf has %s -> %s already, from another localizer or a recording; set tf_broadcast to "
        "false here, or leave that transform out there",
        params_.global_frame_id.c_str(), child.c_str());
}

void LocalizerNode::warnOfSilence() {
  constexpr double kLong = 5;  // s
  if (is_silence_told_ || (ros::WallTime::now() - started_).toSec() < kLong) return;
  is_silence_told_ = true;
  const std::string topic = queue_->silentTopic();
  if (!topic.empty())
    ROS_WARN(
        "no image has come on %s; if only %s/compressed is published, set "
        "image_transport to compressed",
        topic.c_str(), topic.c_str());
}

void LocalizerNode::savePose() {
  PoseGaussian pose;
  {
    const std::lock_guard<std::mutex> lock(localizer_mutex_);
    if (localizer_->state() != LocalizerState::kTracking) return;  // only a trusted pose is stored
    pose = localizer_->filter().estimate();
  }
  const Eigen::Vector3d& p = pose.mean.translation();
  const Eigen::Matrix3d& r = pose.mean.linear();
  private_nh_.setParam("initial_pose_x", p.x());
  private_nh_.setParam("initial_pose_y", p.y());
  private_nh_.setParam("initial_pose_z", p.z());
  private_nh_.setParam("initial_pose_roll", std::atan2(r(2, 1), r(2, 2)));
  private_nh_.setParam("initial_pose_pitch", std::asin(std::max(-1.0, std::min(1.0, -r(2, 0)))));
  private_nh_.setParam("initial_pose_a", std::atan2(r(1, 0), r(0, 0)));
  const Matrix6 c = covarianceInMapAxes(pose);
  const char* axes[] = {"xx", "yy", "zz", "rr", "pp", "aa"};
  for (int i = 0; i < 6; ++i) private_nh_.setParam(std::string("initial_cov_") + axes[i], c(i, i));
}

LocalizerFacts LocalizerNode::facts() {
  const std::lock_guard<std::mutex> lock(localizer_mutex_);
  LocalizerFacts facts = facts_;
  facts.backend = localizer_->map().backend().name();
  if (!last_image_at_.isZero()) facts.silence = (ros::WallTime::now() - last_image_at_).toSec();
  return facts;
}

}  // namespace edge_mcl
