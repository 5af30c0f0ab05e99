#include "edge_mcl/mapping/cloud_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/mapping/depth_fusion.h"

namespace edge_mcl {
namespace {

std::string writeFile(const std::string& name, const std::string& text) {
  std::string file = testing::TempDir() + name;
  std::ofstream(file, std::ios::binary) << text;
  return file;
}

std::string plyOf(const std::vector<Eigen::Vector3d>& points, const std::string& faces = "") {
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex " << points.size()
       << "\nproperty float x\nproperty float y\nproperty float z\n"
       << faces << "end_header\n";
  for (const Eigen::Vector3d& p : points) text << p.x() << " " << p.y() << " " << p.z() << "\n";
  return text.str();
}

TEST(CloudSurface, KnowsPointCloudsByTheirHeader) {
  const std::vector<Eigen::Vector3d> point{{0, 0, 0}};
  EXPECT_TRUE(isPointCloud(writeFile("points.ply", plyOf(point))));
  EXPECT_TRUE(isPointCloud(writeFile(
      "no_faces.ply", plyOf(point, "element face 0\nproperty list uchar int vertex_indices\n"))));
  EXPECT_FALSE(isPointCloud(writeFile(
      "faces.ply", plyOf(point, "element face 1\nproperty list uchar int vertex_indices\n"))));
  EXPECT_TRUE(isPointCloud("room.XYZ"));
  EXPECT_FALSE(isPointCloud("room.obj"));
  EXPECT_FALSE(isPointCloud("missing.ply"));
}

/// Points on the walls of a room of 2 x 1.6 x 1.2 m with a noise of 2 mm. The surface lies on the
/// walls, and its fronts are inside. Poisson reconstruction rounds the corners off, so a tenth of
/// the vertices may be farther from a wall than the spacing.
TEST(CloudSurface, ARoomIsSeenFromInside) {
  if (!DepthFusion::isAvailable()) GTEST_SKIP() << "this build has no Open3D";
  RandomSource random(1);
  const Eigen::Vector3d size(2, 1.6, 1.2);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 40000; ++i) {
    Eigen::Vector3d p(random.uniform(), random.uniform(), random.uniform());
    p = p.cwiseProduct(size);
    const int axis = i % 3;
    p[axis] = (i / 3 % 2 == 0 ? 0 : size[axis]) + 0.002 * random.normal();
    points.push_back(p);
  }
  const MeshSoup surface = surfaceOfCloud(writeFile("room.ply", plyOf(points)), {}, 0.03).soup;
  ASSERT_GT(surface.triangles.size(), 2000u);
  size_t far = 0;
  for (const Eigen::Vector3f& v : surface.vertices) {
    double to_wall = 10;
    for (int k = 0; k < 3; ++k)
      to_wall = std::min({to_wall, std::abs(static_cast<double>(v[k])),
                          std::abs(static_cast<double>(v[k]) - size[k])});
    if (to_wall > 0.03) ++far;
  }
  EXPECT_LT(static_cast<double>(far), 0.1 * static_cast<double>(surface.vertices.size()));
  size_t inward = 0;
  for (const auto& t : surface.triangles) {
    const Eigen::Vector3f a = surface.vertices[t[0]];
    const Eigen::Vector3f normal = (surface.vertices[t[1]] - a).cross(surface.vertices[t[2]] - a);
    if (normal.dot(size.cast<float>() / 2 - a) > 0) ++inward;
  }
  EXPECT_GT(static_cast<double>(inward), 0.98 * static_cast<double>(surface.triangles.size()));
}

/// The same room in millimetres, at a place in its country. The truth is the room in metres.
TEST(CloudSurface, ScaleAndOriginOfTheMapApply) {
  if (!DepthFusion::isAvailable()) GTEST_SKIP() << "this build has no Open3D";
  RandomSource random(1);
  const Eigen::Vector3d size(2, 1.6, 1.2), place(458123.4, 5428765.4, 112);
  std::ostringstream text;
  text.precision(12);
  for (int i = 0; i < 20000; ++i) {
    Eigen::Vector3d p(random.uniform(), random.uniform(), random.uniform());
    p = p.cwiseProduct(size);
    const int axis = i % 3;
    p[axis] = i / 3 % 2 == 0 ? 0 : size[axis];
    text << 1000 * (place + p).transpose() << "\n";
  }
  const std::string file = writeFile("millimetres.xyz", text.str());
  EXPECT_THROW(surfaceOfCloud(file, {}, 0.03), InputError);
  MapParameters params;
  params.scale = 0.001;
  const CloudSurface surface = surfaceOfCloud(file, params, 0.03);
  Eigen::AlignedBox3d box;
  for (const auto& t : surface.soup.triangles)
    for (const uint32_t v : t) box.extend(surface.origin + surface.soup.vertices[v].cast<double>());
  // The surface may bulge by the spacing.
  EXPECT_LT((box.min() - place).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_LT((box.max() - place - size).cwiseAbs().maxCoeff(), 0.03);
  EXPECT_LT(surface.soup.vertices.front().norm(), 200);
}

TEST(CloudSurface, BadFilesAreErrors) {
  if (!DepthFusion::isAvailable()) GTEST_SKIP() << "this build has no Open3D";
  EXPECT_THROW(surfaceOfCloud("missing.ply", {}, 0.02), InputError);
  EXPECT_THROW(surfaceOfCloud(writeFile("few.ply", plyOf({{0, 0, 0}, {1, 0, 0}})), {}, 0.02),
               InputError);
  EXPECT_THROW(surfaceOfCloud(writeFile("broken.ply", "ply\nformat ascii 1.0\n"), {}, 0.02),
               InputError);
}

}  // namespace
}  // namespace edge_mcl
