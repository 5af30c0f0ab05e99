#include "edge_mcl/mapping/cloud_surface.h"

#ifdef EDGE_MCL_HAS_OPEN3D
#include <open3d/geometry/KDTreeFlann.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/io/PointCloudIO.h>
#include <open3d/utility/Logging.h>
#endif

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/map_frame.h"

namespace edge_mcl {

bool isPointCloud(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".pcd" || extension == ".pts" || extension == ".xyz") return true;
  if (extension != ".ply") return false;
  std::ifstream in(file, std::ios::binary);
  size_t faces = 0;
  constexpr int kMostLines = 1000;
  std::string line;
  for (int i = 0; i < kMostLines && std::getline(in, line) && line.rfind("end_header", 0) != 0; ++i)
    if (line.rfind("element face ", 0) == 0) faces = std::strtoull(line.c_str() + 13, nullptr, 10);
  return in && faces == 0;
}

#ifdef EDGE_MCL_HAS_OPEN3D

namespace {

/// Turns all normals when most look away from the middle: a room is scanned from inside.
void lookInwards(open3d::geometry::PointCloud* cloud) {
  const Eigen::Vector3d middle = cloud->GetCenter();
  const auto inward = std::count_if(
      cloud->points_.begin(), cloud->points_.end(), [&](const Eigen::Vector3d& point) {
        const auto i = static_cast<size_t>(&point - cloud->points_.data());
        return cloud->normals_[i].dot(middle - point) > 0;
      });
  if (2 * static_cast<size_t>(inward) >= cloud->points_.size()) return;
  for (Eigen::Vector3d& n : cloud->normals_) n = -n;
}

/// Points of a file, in its coordinates.
open3d::geometry::PointCloud readPoints(const std::string& file) {
  open3d::geometry::PointCloud points;
  const std::string way =
      "; a cloud is a PLY or PCD file, or lines of three numbers (XYZ) or of a PTS file";
  bool is_read = false;
  try {
    is_read = open3d::io::ReadPointCloud(file, points);
  } catch (const std::exception& e) {
    throw InputError(file + ": not readable as a point cloud: " + e.what());
  }
  if (!is_read) throw InputError(file + ": not readable as a point cloud" + way);
  points.RemoveNonFinitePoints();
  if (points.points_.empty()) throw InputError(file + ": no point was found in the file" + way);
  return points;
}

/// Turns the points to the map frame. @return the origin that was subtracted.
Eigen::Vector3d moveToMap(const MapParameters& params, const std::string& file,
                          std::vector<Eigen::Vector3d>* points) {
  const double scale = params.scale > 0 ? params.scale : 1;
  const Eigen::Affine3d to_map = mapTransform(params, scale);
  for (Eigen::Vector3d& p : *points) p = to_map * p;
  Eigen::Vector3d origin = mapOrigin(params, *points);
  Eigen::AlignedBox3d box;
  for (Eigen::Vector3d& p : *points) box.extend(p -= origin);
  const std::string doubt = params.scale > 0 ? "" : sizeDoubt(box.diagonal().norm());
  if (!doubt.empty()) throw InputError(file + ": " + doubt + ", or to 1 when it is that large");
  return origin;
}

}  // namespace

CloudSurface surfaceOfCloud(const std::string& file, const MapParameters& params, double spacing) {
  open3d::utility::SetVerbosityLevel(open3d::utility::VerbosityLevel::Error);
  open3d::geometry::PointCloud points = readPoints(file);
  CloudSurface surface;
  surface.origin = moveToMap(params, file, &points.points_);
  const auto cloud = points.VoxelDownSample(spacing);
  constexpr size_t kFewest = 1000;
  if (cloud->points_.size() < kFewest)
    throw InputError(file + ": the cloud has only " + std::to_string(cloud->points_.size()) +
                     " points that are " + std::to_string(spacing) + " m apart");
  constexpr int kNeighbours = 30;
  cloud->EstimateNormals(open3d::geometry::KDTreeSearchParamKNN(kNeighbours));
  cloud->OrientNormalsConsistentTangentPlane(kNeighbours / 2);
  lookInwards(cloud.get());
  // The octree's finest cells are about as large as the spacing.
  const double size = (cloud->GetMaxBound() - cloud->GetMinBound()).maxCoeff();
  const auto depth =
      static_cast<size_t>(std::clamp(std::ceil(std::log2(1.1 * size / spacing)), 5.0, 11.0));
  const auto mesh =
      std::get<0>(open3d::geometry::TriangleMesh::CreateFromPointCloudPoisson(*cloud, depth));
  const open3d::geometry::KDTreeFlann tree(*cloud);
  std::vector<bool> is_near(mesh->vertices_.size());
  for (size_t i = 0; i < is_near.size(); ++i) {
    std::vector<int> index;
    std::vector<double> squared;
    is_near[i] = tree.SearchKNN(mesh->vertices_[i], 1, index, squared) > 0 &&
                 squared.front() < 9 * spacing * spacing;
  }
  MeshSoup& soup = surface.soup;
  for (const Eigen::Vector3d& v : mesh->vertices_) soup.vertices.push_back(v.cast<float>());
  for (const Eigen::Vector3i& t : mesh->triangles_) {
    if (!is_near[t.x()] || !is_near[t.y()] || !is_near[t.z()]) continue;
    soup.triangles.push_back(
        {static_cast<uint32_t>(t.x()), static_cast<uint32_t>(t.y()), static_cast<uint32_t>(t.z())});
    soup.triangle_material.push_back(0);
  }
  return surface;
}

#else

CloudSurface surfaceOfCloud(const std::string& /*file*/, const MapParameters& /*params*/,
                            double /*spacing*/) {
  throw Error("this build has no Open3D, which puts a surface through a point cloud");
}

#endif

}  // namespace edge_mcl
