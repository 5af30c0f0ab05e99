/// A surface through the points of a laser scanner or of photogrammetry.
#pragma once

#include <string>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Whether a file is a point cloud: PLY without faces, PCD, PTS, XYZ.
bool isPointCloud(const std::string& file);

/// Reads a point cloud and puts a surface through its points, by Open3D: the points are thinned to
/// one in each cube, get normals that agree with their neighbours', and Poisson reconstruction (M.
/// Kazhdan, H. Hoppe, "Screened Poisson surface reconstruction", 2013) makes faces. Faces far from
/// any point are dropped.
/// @param spacing size of the cubes, m.
/// @throws InputError when the file cannot be read or has too few points; Error without Open3D.
MeshSoup surfaceOfCloud(const std::string& file, double spacing);

}  // namespace edge_mcl
