#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/edges/model_hints.h"
#include "edge_mcl/mapping/depth_fusion.h"
#include "edge_mcl/mapping/face_simplification.h"
#include "edge_mcl/mapping/line_tracks.h"
#include "edge_mcl/mapping/scan_views.h"

namespace edge_mcl {
namespace {

/// A room of 4 x 3 x 2.4 m, scanned from inside: faces of 4 cm whose corners are off by 5 mm.
MeshModel scannedRoom() {
  RandomSource random(1);
  MeshSoup soup;
  const auto addWall = [&](const Eigen::Vector3f& at, const Eigen::Vector3f& u,
                           const Eigen::Vector3f& v) {
    constexpr float kFace = 0.04f;
    const auto nu = static_cast<uint32_t>(std::lround(u.norm() / kFace));
    const auto nv = static_cast<uint32_t>(std::lround(v.norm() / kFace));
    const Eigen::Vector3f normal = u.cross(v).normalized();
    const auto first = static_cast<uint32_t>(soup.vertices.size());
    for (uint32_t j = 0; j <= nv; ++j)
      for (uint32_t i = 0; i <= nu; ++i)
        soup.vertices.push_back(at + u * (static_cast<float>(i) / nu) +
                                v * (static_cast<float>(j) / nv) +
                                normal * static_cast<float>(0.005 * random.normal()));
    for (uint32_t j = 0; j < nv; ++j)
      for (uint32_t i = 0; i < nu; ++i) {
        const uint32_t a = first + j * (nu + 1) + i;
        soup.triangles.push_back({a, a + 1, a + nu + 2});
        soup.triangles.push_back({a, a + nu + 2, a + nu + 1});
      }
  };
  const Eigen::Vector3f x(4, 0, 0), y(0, 3, 0), z(0, 0, 2.4f), o(0, 0, 0);
  addWall(o, x, y);
  addWall(o + z, y, x);
  addWall(o, z, x);
  addWall(o + y, x, z);
  addWall(o, y, z);
  addWall(o + x, z, y);
  soup.triangle_material.assign(soup.triangles.size(), 0);
  return weldMesh(std::move(soup), 1e-6, "scan");
}

/// Distance of a point from the nearest edge of the room.
double distanceFromEdges(const Eigen::Vector3d& p) {
  const Eigen::Vector3d size(4, 3, 2.4);
  std::array<double, 3> to_wall{};
  for (int k = 0; k < 3; ++k) to_wall[k] = std::min(std::abs(p[k]), std::abs(p[k] - size[k]));
  std::sort(to_wall.begin(), to_wall.end());
  return std::hypot(to_wall[0], to_wall[1]);
}

/// The truth is the twelve edges of the room, 37.6 m. The noise of the scan is 5 mm, and its views
/// have a pixel of 6 mm at 2 m.
TEST(ScanViews, ShowTheEdgesOfTheRoomAndNotTheNoise) {
  MeshModel mesh = scannedRoom();
  EXPECT_TRUE(looksLikeScan(mesh, buildEdgeModel(&mesh, {})));
  const ScanViews views(mesh);
  const std::vector<ScanViews::View> places = views.views({1});
  ASSERT_GT(places.size(), 20u);
  const CameraRays rays(views.camera());
  SegmentOptions options;
  options.needs_both_sides = true;
  options.min_extrapolation = 0;  // the depth of a rendered scan has no noise of its own
  std::vector<DepthSegment> segments;
  for (size_t i = 0; i < places.size(); i += 5)
    for (const MappingImage& image : views.render(places[i])) {
      const auto found = findDepthSegments(image, rays, options);
      segments.insert(segments.end(), found.begin(), found.end());
    }
  TrackOptions tracking;
  tracking.focal = views.camera().fx;
  double length = 0, elsewhere = 0;
  for (const MappedLine& line : trackLines(segments, tracking)) {
    const bool is_edge = distanceFromEdges(line.start) < 0.04 && distanceFromEdges(line.end) < 0.04;
    (is_edge ? length : elsewhere) += (line.end - line.start).norm();
  }
  EXPECT_GT(length, 0.6 * 37.6);
  EXPECT_LT(elsewhere, 0.02 * 37.6);
}

/// The floor of the room is 1 m below the camera, which looks along it. At 8 degrees noise makes
/// steps of depth, so such pixels have none; at 15 degrees they have the depth of the floor.
TEST(ScanViews, ASurfaceThatIsSeenAtASmallAngleHasNoDepth) {
  MeshSoup soup;
  soup.vertices = {{-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  soup.triangle_material = {0, 0};
  const MeshModel mesh = weldMesh(std::move(soup), 1e-6, "floor");
  const ScanViews views(mesh);
  ScanViews::View view;
  view.T_map_camera.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;  // looks along x
  view.T_map_camera.translation() = Eigen::Vector3d(0, 0, 1);
  const cv::Mat depth = views.render(view).front().depth;
  const auto rowAt = [&](double degrees) {
    return static_cast<int>(
        std::lround(views.camera().cy + views.camera().fy * std::tan(degrees * M_PI / 180)));
  };
  const int middle = depth.cols / 2;
  EXPECT_EQ(depth.at<float>(rowAt(8), middle), 0);
  EXPECT_NEAR(depth.at<float>(rowAt(15), middle), 1 / std::tan(15 * M_PI / 180), 0.05);
}

/// A cube of 20 cm holds up to 50 faces. Where a wall runs along the border of two cubes, the noise
/// spreads its vertices over both, so that up to four of six faces remain. All vertices stay on the
/// walls.
TEST(FaceSimplification, AWallStaysAWall) {
  const MeshModel mesh = scannedRoom();
  const MeshSoup faces = simplifiedFaces(mesh.vertices, mesh.triangles, 0.2);
  EXPECT_LT(faces.triangles.size(), mesh.triangles.size() / 6);
  const Eigen::Vector3f size(4, 3, 2.4f);
  for (const Eigen::Vector3f& v : faces.vertices) {
    float to_wall = 10;
    for (int k = 0; k < 3; ++k)
      to_wall = std::min({to_wall, std::abs(v[k]), std::abs(v[k] - size[k])});
    EXPECT_LT(to_wall, 0.1f);  // half a cube, in the corners of the room
  }
}

/// Three cameras look at a wall 2 m away. The fused faces lie on the wall.
TEST(DepthFusion, FacesLieOnTheSurface) {
  if (!DepthFusion::isAvailable()) GTEST_SKIP() << "this build has no Open3D";
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 260;
  camera.cx = 159.5;
  camera.cy = 119.5;
  camera.validate("test");
  DepthFusion fusion(camera, {});
  for (uint32_t i = 0; i < 3; ++i) {
    MappingImage image;
    image.depth = cv::Mat(240, 320, CV_32F, cv::Scalar(2));
    image.T_map_camera.translation() = Eigen::Vector3d(0.1 * i, 0, 1);
    fusion.add(image);
  }
  const MeshSoup faces = fusion.faces();
  ASSERT_GT(faces.triangles.size(), 100u);
  for (const Eigen::Vector3f& v : faces.vertices) EXPECT_NEAR(v.z(), 3, 0.005);
}

/// A camera with barrel distortion looks at a floor that it sees at an angle. Without a correction
/// the fused faces are off by up to 17 cm in the corners of the image.
TEST(DepthFusion, TheDistortionOfTheCameraIsTakenOut) {
  if (!DepthFusion::isAvailable()) GTEST_SKIP() << "this build has no Open3D";
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 260;
  camera.cx = 159.5;
  camera.cy = 119.5;
  camera.distortion = DistortionModel::kPlumbBob;
  camera.coefficients = {-0.2, 0, 0, 0, 0};
  camera.validate("test");
  const CameraRays rays(camera);
  MappingImage image;
  image.depth = cv::Mat(240, 320, CV_32F, cv::Scalar(0));
  // The plane is z = 2 + 0.8 x in the axes of the camera.
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) image.depth.at<float>(y, x) = 2 / (1 - 0.8f * rays.at(x, y).x());
  DepthFusion fusion(camera, {});
  for (int i = 0; i < 3; ++i) fusion.add(image);
  const MeshSoup faces = fusion.faces();
  ASSERT_GT(faces.triangles.size(), 100u);
  double worst = 0;
  for (const Eigen::Vector3f& v : faces.vertices)
    worst = std::max(worst,
                     std::abs(2 + 0.8 * static_cast<double>(v.x()) - static_cast<double>(v.z())) /
                         std::hypot(1, 0.8));
  EXPECT_LT(worst, 0.03);  // a voxel and a half; nearest pixels are off by 1 cm
}

}  // namespace
}  // namespace edge_mcl
