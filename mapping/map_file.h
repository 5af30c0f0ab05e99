/// The file of a map that was made from a scan or a recording.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"
#include "edge_mcl/mapping/line_tracks.h"

namespace edge_mcl {

/// Writes lines and hiding faces to an OBJ file, metres. The lines are in objects named lines_5mm,
/// lines_10mm and so on by their standard deviation. The faces are in the object `hiding_faces`:
/// they hide what is behind them, and their creases are no feature edges (see mesh_loader.h).
/// @param origin of the faces in the coordinates of the lines, m: faces are in single precision.
/// @throws InputError when the file cannot be written.
void writeMapFile(const std::string& file, const std::vector<MappedLine>& lines,
                  const MeshSoup& hiding_faces, const Eigen::Vector3d& origin,
                  const std::string& comment);

}  // namespace edge_mcl
