#include "edge_mcl/core/places/building_axes.h"

#include <cmath>

#include "edge_mcl/core/edges/main_directions.h"

namespace edge_mcl {

std::optional<BuildingAxes> buildingAxes(const EdgeModel& model) {
  constexpr double kLeastShare = 0.5;
  BuildingAxes axes;
  for (const Eigen::Vector3d& direction : mainDirections(model)) {
    const Eigen::Vector3d level(direction.x(), direction.y(), 0);
    if (level.norm() < std::cos(kAlongAxis)) continue;
    axes.R_map_building.col(0) = level.normalized();
    axes.R_map_building.col(1) = Eigen::Vector3d::UnitZ().cross(level.normalized());
    break;
  }
  double all = 0, along = 0;
  for (const EdgeLine& line : model.lines) {
    if (line.kind == EdgeKind::kContour) continue;
    const auto length = static_cast<double>(line.length());
    all += length;
    const Eigen::Vector3d in_building =
        axes.R_map_building.transpose() * line.tangent().cast<double>();
    if (in_building.cwiseAbs().maxCoeff() > std::cos(kAlongAxis)) along += length;
  }
  if (all <= 0) return std::nullopt;
  axes.share = along / all;
  if (axes.share < kLeastShare) return std::nullopt;
  return axes;
}

}  // namespace edge_mcl
