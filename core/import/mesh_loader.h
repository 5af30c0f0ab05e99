/// Model files as meshes in the map frame.
#pragma once

#include <string>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Name of an object whose faces hide what is behind them and have no edges of their own, such as
/// the faces of a scan. Something may precede it: thing_3_hiding_faces.
constexpr const char* kHidingFaces = "hiding_faces";

/// Reads a model file of any format that assimp knows. It applies the unit of the file or
/// `map.scale`, the transform of `params`, `map.origin`, `map.include` and `map.exclude`, and adds
/// the files of `map.additions`. These do not move the origin, and `map.include` does not name
/// their objects.
/// @throws InputError when a file is missing, broken or empty or has bad vertices, or when the
///   file holds coordinates that are rounded to more than 10 mm.
MeshModel loadMesh(const std::string& file, const MapParameters& params);

}  // namespace edge_mcl
