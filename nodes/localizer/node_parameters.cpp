#include "edge_mcl/nodes/localizer/node_parameters.h"

#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_text.h"

namespace edge_mcl {

namespace {

std::string textOf(const XmlRpc::XmlRpcValue& value) {
  using Value = XmlRpc::XmlRpcValue;
  Value copy = value;
  switch (copy.getType()) {
    case Value::TypeBoolean:
      return static_cast<bool>(copy) ? "true" : "false";
    case Value::TypeInt:
      return std::to_string(static_cast<int>(copy));
    case Value::TypeDouble:
      return parameter_text::toText(static_cast<double>(copy));
    case Value::TypeString:
      return static_cast<std::string>(copy);
    case Value::TypeArray: {
      std::string list;
      for (int i = 0; i < copy.size(); ++i) list += (i > 0 ? "," : "") + textOf(copy[i]);
      return list;
    }
    default:
      return "(not a plain value)";
  }
}

/// @return why it cannot be set; empty when it was.
std::string trySet(const std::string& name, const std::string& value, NodeParameters* node,
                   bool* known) {
  std::string fault;
  *known = false;
  node->visit([&](const char* field_name, auto& field, const char*, const char*) {
    if (name != field_name) return;
    *known = true;
    auto parsed = field;
    if (parameter_text::fromText(value, &parsed))
      field = parsed;
    else
      fault =
          "parameter '" + name + "': '" + value + "' is not " + parameter_text::typeName(parsed);
  });
  return fault;
}

}  // namespace

bool isForeignParameter(const std::string& name) {
  // Plugins of image_transport (compressed, theora, ...) keep theirs below the topic's name, or as
  // subscribers in a namespace called like themselves.
  for (const char* prefix : {"image_transport", "num_worker_threads", "adjust/", "overlay/",
                             "compressed/", "compressedDepth/", "theora/"})
    if (name.rfind(prefix, 0) == 0) return true;
  return name == "diagnostic_period";
}

void NodeParameters::validate() const {
  std::string faults;
  const auto require = [&](bool good, const std::string& what) {
    if (!good) faults += (faults.empty() ? "" : "; ") + what;
  };
  const auto not_negative = [](double v) { return std::isfinite(v) && v >= 0; };
  require(!model_file.empty(), "model_file is not set");
  require(odometry == "tf" || odometry == "topic" || odometry == "none",
          "odometry = " + odometry + " must be tf, topic or none");
  require(mask_policy == "unmasked" || mask_policy == "skip_update" || mask_policy == "use_last",
          "mask_policy = " + mask_policy + " must be unmasked, skip_update or use_last");
  require(not_negative(transform_tolerance), "transform_tolerance must be zero or more");
  require(not_negative(transform_timeout), "transform_timeout must be zero or more");
  require(not_negative(camera_window), "camera_window must be zero or more");
  require(not_negative(camera_timeout), "camera_timeout must be zero or more");
  require(std::isfinite(imu_sigma) && imu_sigma > 0, "imu_sigma must be positive");
  require(not_negative(depth_timeout), "depth_timeout must be zero or more");
  require(not_negative(depth_window), "depth_window must be zero or more");
  require(not_negative(mask_timeout), "mask_timeout must be zero or more");
  require(not_negative(save_pose_rate), "save_pose_rate must be zero or more");
  require(max_cloud_poses >= 1, "max_cloud_poses must be at least 1");
  require(!global_frame_id.empty() && !base_frame_id.empty(), "frames must have names");
  require(odometry == "none" || !odom_frame_id.empty(), "odom_frame_id must have a name");
  for (const double variance : {initial_cov_xx, initial_cov_yy, initial_cov_zz, initial_cov_rr,
                                initial_cov_pp, initial_cov_aa})
    require(not_negative(variance), "initial_cov_* must be zero or more");
  if (!faults.empty()) throw ParameterError("parameters: " + faults);
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

void applyParameters(const std::map<std::string, std::string>& values, NodeParameters* node,
                     Parameters* method) {
  std::vector<std::string> all_names;
  node->visit(
      [&](const char* name, auto&, const char*, const char*) { all_names.push_back(name); });
  for (const auto& d : method->describe()) {
    std::string name = d.name;
    name[name.find('.')] = '/';
    all_names.push_back(name);
  }
  std::string faults;
  const auto complain = [&](const std::string& fault) {
    faults += (faults.empty() ? "" : "; ") + fault;
  };
  for (const auto& [name, value] : values) {
    if (isForeignParameter(name)) continue;
    bool known = false;
    const std::string fault = trySet(name, value, node, &known);
    if (!fault.empty()) complain(fault);
    if (known) {
      if (name.rfind("initial_pose_", 0) == 0) node->has_initial_pose = true;
      continue;
    }
    std::string dotted = name;
    if (const auto slash = dotted.find('/'); slash != std::string::npos) dotted[slash] = '.';
    try {
      method->set(dotted, value);
    } catch (const ParameterError& e) {
      if (std::find(all_names.begin(), all_names.end(), name) != all_names.end())
        complain(e.what());
      else
        complain("unknown parameter '~" + name + "' (nearest: '~" + nearestName(name, all_names) +
                 "')");
    }
  }
  if (values.count("update_min_d")) method->tracking.update_min_d = node->update_min_d;
  if (values.count("recovery_alpha_slow"))
    method->filter.recovery_alpha_slow = node->recovery_alpha_slow;
  if (values.count("recovery_alpha_fast"))
    method->filter.recovery_alpha_fast = node->recovery_alpha_fast;
  if (values.count("update_min_a"))
    method->tracking.update_min_a_deg = node->update_min_a * 180 / M_PI;
  for (const auto validate : {0, 1}) {
    try {
      if (validate == 0)
        node->validate();
      else
        method->validate();
    } catch (const ParameterError& e) {
      complain(e.what());
    }
  }
  if (!faults.empty()) throw ParameterError(faults);
}

std::map<std::string, std::string> readPrivateParameters(const ros::NodeHandle& private_nh) {
  std::map<std::string, std::string> values;
  std::vector<std::string> names;
  private_nh.getParamNames(names);
  const std::string prefix = private_nh.getNamespace() + "/";
  for (const std::string& name : names) {
    if (name.rfind(prefix, 0) != 0) continue;
    XmlRpc::XmlRpcValue value;
    if (private_nh.getParam(name, value)) values[name.substr(prefix.size())] = textOf(value);
  }
  return values;
}

}  // namespace edge_mcl
