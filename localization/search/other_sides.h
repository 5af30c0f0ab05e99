/// Poses from which an object looks much the same: on its other sides.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// An object that is seen from outside often looks alike from several sides: a cupboard from
/// behind, a table from all four. A search must compare these sides, since the images of one of
/// them fit the others nearly as well. See docs/decisions/search-other-sides.md.
class OtherSides {
 public:
  /// Finds the middles of what stands in the model. There are none when the model surrounds the
  /// camera: a building has prepared places, and all of them are compared.
  explicit OtherSides(const LocalizationMap& map);

  /// Poses turned by quarters about the vertical through each middle. @param pose T_map_base
  std::vector<Pose> of(const Pose& pose) const;

 private:
  std::vector<Eigen::Vector3d> middles_;  // map frame, m
};

}  // namespace edge_mcl
