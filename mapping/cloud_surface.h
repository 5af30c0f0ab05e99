/// A surface through the points of a laser scanner or of photogrammetry.
#pragma once

#include <string>

#include "edge_mcl/core/base/measurement_parameters.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// A surface in the map frame.
struct CloudSurface {
  MeshSoup soup;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the map frame, as MeshModel::origin
};

/// Whether a file is a point cloud: PLY without faces, PCD, PTS, XYZ.
bool isPointCloud(const std::string& file);

/// Reads a point cloud and puts a surface through its points, by Open3D: the points are thinned to
/// one in each cube, get normals that agree with their neighbours', and Poisson reconstruction (M.
/// Kazhdan, H. Hoppe, "Screened Poisson surface reconstruction", 2013) makes faces. Faces far from
/// any point are dropped.
/// `map.scale`, the transform of `params` and `map.origin` are applied first.
/// @param spacing size of the cubes, m.
/// @throws InputError when the file cannot be read or has too few points, or when it is as large as
///   a town although no scale is given; Error without Open3D.
CloudSurface surfaceOfCloud(const std::string& file, const MapParameters& params, double spacing);

}  // namespace edge_mcl
