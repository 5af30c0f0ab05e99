#include "edge_mcl/nodes/common/private_parameters.h"

#include <ros/console.h>
#include <xmlrpcpp/XmlRpcValue.h>

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

/// Launch files set these in a node by habit. They say so and are left out.
bool isMisplaced(const std::string& name) {
  if (name == "use_sim_time") {
    ROS_WARN("~use_sim_time has no effect in a node; set /use_sim_time");
    return true;
  }
  if (name == "tf_prefix") {
    ROS_WARN(
        "~tf_prefix is not used, since tf2 has no prefixes; write the prefix into the names of the "
        "frames (base_frame_id: robot1/base_link)");
    return true;
  }
  return false;
}

}  // namespace

bool isForeignParameter(const std::string& name) {
  // The plugins of image_transport keep their parameters below the topic's name. Their subscribers
  // keep them in a namespace with the plugin's name.
  for (const char* prefix : {"image_transport", "num_worker_threads", "adjust/", "overlay/",
                             "compressed/", "compressedDepth/", "theora/"})
    if (name.rfind(prefix, 0) == 0) return true;
  return name == "diagnostic_period";
}

std::map<std::string, std::string> readPrivateParameters(const ros::NodeHandle& private_nh) {
  std::map<std::string, std::string> values;
  std::vector<std::string> names;
  private_nh.getParamNames(names);
  const std::string prefix = private_nh.getNamespace() + "/";
  for (const std::string& name : names) {
    if (name.rfind(prefix, 0) != 0) continue;
    if (isMisplaced(name.substr(prefix.size()))) continue;
    XmlRpc::XmlRpcValue value;
    if (private_nh.getParam(name, value)) values[name.substr(prefix.size())] = textOf(value);
  }
  return values;
}

}  // namespace edge_mcl
