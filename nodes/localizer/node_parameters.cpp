#include "edge_mcl/nodes/localizer/node_parameters.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/nodes/common/private_parameters.h"

namespace edge_mcl {

std::vector<std::string> NodeParameters::faults() const {
  std::vector<std::string> list;
  if (model_file.empty()) list.emplace_back("model_file is not set");
  if (global_frame_id.empty() || base_frame_id.empty()) list.emplace_back("frames must have names");
  if (odometry != "none" && odom_frame_id.empty())
    list.emplace_back("odom_frame_id must have a name");
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
  std::vector<std::string> names;
  std::istringstream list(cameras);
  for (std::string name; std::getline(list, name, ',');)
    if (!name.empty()) names.push_back(name);
  if (names.empty()) names.emplace_back();
  return names;
}

namespace {

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
    if (isForeignParameter(name)) continue;
    std::string dotted = name;
    if (const auto slash = dotted.find('/'); slash != std::string::npos) dotted[slash] = '.';
    std::optional<std::string> fault = trySetParameter(name, value, node);
    if (fault && name.rfind("initial_pose_", 0) == 0) node->has_initial_pose = true;
    if (!fault) fault = trySetParameter(dotted, value, method);
    if (!fault)
      faults.push_back(unknownParameter(name, namesInRos(*node, *method), "~"));
    else if (!fault->empty())
      faults.push_back(*fault);
  }
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
