#include "edge_mcl/nodes/localizer/node_parameters.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/nodes/common/private_parameters.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

namespace {

std::vector<std::string> entriesOf(const std::string& list) {
  std::vector<std::string> entries;
  std::istringstream stream(list);
  for (std::string entry; std::getline(stream, entry, ',');)
    if (!entry.empty()) entries.push_back(entry);
  return entries;
}

}  // namespace

std::vector<std::string> NodeParameters::faults() const {
  std::vector<std::string> list;
  if (model_file.empty()) list.emplace_back("model_file is not set");
  if (global_frame_id.empty() || base_frame_id.empty()) list.emplace_back("frames must have names");
  if (odometry != "none" && odom_frame_id.empty())
    list.emplace_back("odom_frame_id must have a name");
  const size_t cameras_count = cameraNames().size();
  for (const auto& [name, value] :
       {std::pair{"camera_file", camera_file}, std::pair{"camera_frame_id", camera_frame_id}})
    if (const size_t count = entriesOf(value).size(); count > 0 && count != cameras_count)
      list.push_back(std::string(name) + " has " + std::to_string(count) + " entries for " +
                     std::to_string(cameras_count) + " cameras");
  return list;
}

PoseGaussian NodeParameters::initialPose() const {
  PoseGaussian pose;
  pose.mean.translation() = Eigen::Vector3d(initial_pose_x, initial_pose_y, initial_pose_z);
  pose.mean.linear() = rotationFromAngles(initial_pose_roll, initial_pose_pitch, initial_pose_a);
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal() << initial_cov_xx, initial_cov_yy, initial_cov_zz, initial_cov_rr,
      initial_cov_pp, initial_cov_aa;
  pose.covariance = covarianceFromMapAxes(pose.mean, covariance);
  return pose;
}

std::vector<std::string> NodeParameters::cameraNames() const {
  std::vector<std::string> names = entriesOf(cameras);
  if (names.empty()) names.emplace_back();
  return names;
}

std::vector<std::string> NodeParameters::perCamera(const std::string& list) const {
  std::vector<std::string> entries = entriesOf(list);
  entries.resize(cameraNames().size());
  return entries;
}

bool NodeParameters::isRectified(const std::string& topic) const {
  return rectified == "true" || (rectified == "auto" && isRectifiedTopic(topic));
}

namespace {

/// What takes the place of a parameter that only amcl has; empty: nothing is known of it.
std::string adviceForAmcl(const std::string& name) {
  const auto begins = [&](const char* prefix) { return name.rfind(prefix, 0) == 0; };
  if (name == "min_particles" || name == "max_particles" || begins("kld_"))
    return "set filter/particles, since the number of particles is fixed";
  if (begins("odom_alpha") || name == "odom_model_type")
    return "set filter/odometry_noise_* for a robot that moves in 3D";
  if (begins("laser_") || begins("beam_skip") || name == "do_beamskip")
    return "a camera takes the place of the laser: likelihood/* and image/*";
  if (name == "use_map_topic" || name == "first_map_only") return "set model_file";
  if (name == "resample_interval" || name == "selective_resampling")
    return "set filter/resample_threshold";
  if (name == "gui_publish_rate") return "particles are published with every image";
  if (name == "force_update_after_initialpose" || name == "force_update_after_set_map")
    return "the next image after either is always used";
  return "";
}

/// The names of both structs as ROS has them.
std::vector<std::string> namesInRos(const NodeParameters& node, const Parameters& method) {
  std::vector<std::string> names = parameterNames(node);
  for (std::string name : parameterNames(method)) {
    name[name.find('.')] = '/';
    names.push_back(name);
  }
  return names;
}

}  // namespace

void applyParameters(const std::map<std::string, std::string>& values, NodeParameters* node,
                     Parameters* method) {
  std::vector<std::string> faults;
  for (const auto& [name, value] : values) {
    std::string dotted = name;
    if (const auto slash = dotted.find('/'); slash != std::string::npos) dotted[slash] = '.';
    std::optional<std::string> fault = trySetParameter(name, value, node);
    if (fault && name.rfind("initial_pose_", 0) == 0) node->has_initial_pose = true;
    if (!fault) fault = trySetParameter(dotted, value, method);
    if (!fault && isForeignParameter(name)) continue;
    if (!fault && !adviceForAmcl(name).empty())
      faults.push_back("parameter '~" + name + "' is amcl's; " + adviceForAmcl(name));
    else if (!fault)
      faults.push_back(unknownParameter(name, namesInRos(*node, *method), "~"));
    else if (!fault->empty())
      faults.push_back(*fault);
  }
  for (std::string* frame : {&node->global_frame_id, &node->odom_frame_id, &node->base_frame_id})
    *frame = frameName(*frame);
  if (values.count("update_min_d")) method->tracking.update_min_d = node->update_min_d;
  if (values.count("recovery_alpha_slow"))
    method->filter.recovery_alpha_slow = node->recovery_alpha_slow;
  if (values.count("recovery_alpha_fast"))
    method->filter.recovery_alpha_fast = node->recovery_alpha_fast;
  if (values.count("update_min_a"))
    method->tracking.update_min_a_deg = node->update_min_a * 180 / M_PI;
  for (std::string& fault : parameterFaults(*node)) faults.push_back(std::move(fault));
  for (std::string& fault : parameterFaults(*method)) faults.push_back(std::move(fault));
  throwFaults(faults);
}

}  // namespace edge_mcl
