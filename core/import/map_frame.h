/// Where the coordinates of a file lie in the map frame.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "edge_mcl/core/base/measurement_parameters.h"

namespace edge_mcl {

/// Whole hundreds next to the median of the coordinates, when the points lie together far from
/// zero; else zero. A quarter of the points may lie elsewhere.
/// @param points finite, in any unit. @param far distance that is far, in the same unit.
Eigen::Vector3d farPart(const std::vector<Eigen::Vector3d>& points, double far);

/// Transform from the file to the map frame before the origin is subtracted, as `params` say.
/// @param scale metres per unit of the file.
Eigen::Affine3d mapTransform(const MapParameters& params, double scale);

/// Origin of the map frame: `map.origin`, or near the points when they are far from zero.
/// @param points after mapTransform(), m.
Eigen::Vector3d mapOrigin(const MapParameters& params, const std::vector<Eigen::Vector3d>& points);

/// Text of a point for messages, m.
std::string metresText(const Eigen::Vector3d& point);

/// What a user should know about an origin that is not zero.
std::string originNote(const Eigen::Vector3d& origin);

/// Asks for the unit when a model is as large as a town. Empty when its size is usual.
/// @param diagonal of the model, m.
std::string sizeDoubt(double diagonal);

}  // namespace edge_mcl
