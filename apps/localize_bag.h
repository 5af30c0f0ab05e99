/// edge-mcl localize on a ROS bag.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>

#include "common_options.h"

namespace edge_mcl {

struct LocalizeOptions {
  std::string sequence, model, out = "est.txt", stats, overlay, plot, initial_std, masks, up;
  std::string topics, initial_pose;  // of a bag
  bool no_mask = false, depth = false, json = false, global = false;
  ParameterOptions parameters;
};

/// The method's parameters, with what --depth makes of them. @throws ParameterError
Parameters parametersOf(const LocalizeOptions& options);

/// "0.1,3": metres and degrees, as metres and radians. @throws ParameterError
std::pair<double, double> parseInitialStd(const std::string& text);

/// "0,-1,0": a direction; empty: none. @throws ParameterError
std::optional<Eigen::Vector3d> parseUp(const std::string& text);

/// Reads the bag as fast as it can, with the same result whatever that is.
/// @throws InputError in a build without ROS.
int localizeBag(const LocalizeOptions& options);

}  // namespace edge_mcl
