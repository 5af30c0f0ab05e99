/// Moves a model file near its origin before it is read in single precision.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace edge_mcl {

/// Contents of a file whose coordinates are near its origin.
struct ShiftedFile {
  std::string contents;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< was subtracted, in units of the file
};

/// Subtracts a whole number from coordinates that are far from the origin, such as national or UTM
/// coordinates. Importers round coordinates to single precision, which is 0.5 m at 5,000 km. Known
/// are OBJ, STL and PLY (text, and binary PLY in double precision), Collada and IFC.
/// @return nothing when no coordinate of the nearest vertex is beyond 2000 units, or when the
///   format is another one.
std::optional<ShiftedFile> shiftedNearOrigin(const std::string& file);

}  // namespace edge_mcl
