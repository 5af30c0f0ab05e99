/// The three perpendicular directions of a building with right angles.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// Axes of a building: two horizontal ones along its walls, and the vertical.
struct BuildingAxes {
  /// R_map_building: its columns are the axes in the map frame. The third one is z.
  Eigen::Matrix3d R_map_building = Eigen::Matrix3d::Identity();
  /// Share of the model's line length that is parallel to an axis, within kAlongAxis.
  double share = 0;
};

/// Lines with a larger angle to an axis are not parallel to it, rad.
constexpr double kAlongAxis = 0.05;  // 3 degrees, as in mainDirections()

/// Finds the axes of a building. @return none when less than half of the model's line length is
/// parallel to them: then lines along axes do not describe it.
std::optional<BuildingAxes> buildingAxes(const EdgeModel& model);

}  // namespace edge_mcl
