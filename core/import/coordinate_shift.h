/// Moves a model file near its origin before it is read in single precision.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace edge_mcl {

/// Contents of a file that was changed before an importer reads it.
struct ShiftedFile {
  std::string contents;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< was subtracted, in units of the file
};

/// Subtracts a whole number from coordinates that are far from the origin, such as national or UTM
/// coordinates. Importers round coordinates to single precision, which is 0.5 m at 5,000 km. Known
/// are OBJ, STL and PLY (text, and binary PLY in double precision), Collada and IFC. It joins the
/// names of an OBJ file, too (joinObjectNames()).
/// @return nothing when the file stays as it is: most vertices are within 2000 units of the origin,
///   or the format is another one.
std::optional<ShiftedFile> shiftedNearOrigin(const std::string& file);

}  // namespace edge_mcl
