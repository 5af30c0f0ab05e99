#include "edge_mcl/localization/objects/point_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace edge_mcl {
namespace {

/// Points 5 cm apart that fill a box.
std::vector<Eigen::Vector3f> filled(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  std::vector<Eigen::Vector3f> points;
  for (float x = low.x(); x <= high.x(); x += 0.05F)
    for (float y = low.y(); y <= high.y(); y += 0.05F)
      for (float z = low.z(); z <= high.z(); z += 0.05F) points.emplace_back(x, y, z);
  return points;
}

std::vector<Eigen::Vector3f> both(std::vector<Eigen::Vector3f> a,
                                  const std::vector<Eigen::Vector3f>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(PointClusters, VoxelsKeepTheMeanAndTheNumberOfTheirPoints) {
  const std::vector<VoxelPoint> voxels =
      voxelsOf({{0.01F, 0.01F, 0.01F}, {-0.01F, 0.01F, 0.01F}, {0.05F, 0.03F, 0.09F}}).list;
  ASSERT_EQ(voxels.size(), 2U);
  EXPECT_EQ(voxels[0].count, 1);
  EXPECT_EQ(voxels[1].count, 2);
  EXPECT_TRUE(voxels[1].point.isApprox(Eigen::Vector3f(0.03F, 0.02F, 0.05F), 1e-5F));
}

TEST(PointClusters, PointsThatAreNotFiniteOrFarAwayAreLeftOut) {
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(voxelsOf({{inf, 0, 0}, {0, -inf, 0}, {0, 0, inf - inf}, {1e6F, 0, 0}}).list.empty());
  EXPECT_TRUE(clustersOf({}, {}).empty());
}

/// 0.35 m are more than two voxels, wherever their borders lie.
TEST(PointClusters, ThingsSideBySideAreApart) {
  for (const float shift : {0.0F, 0.03F, 0.07F, -5.02F}) {
    const auto points = both(filled({shift, 0, 0}, {shift + 0.4F, 0.4F, 1}),
                             filled({shift + 0.75F, 0, 0}, {shift + 1.2F, 0.4F, 1.5F}));
    const std::vector<PointCluster> clusters = clustersOf(voxelsOf(points), {});
    ASSERT_EQ(clusters.size(), 2U) << shift;
    EXPECT_EQ(static_cast<size_t>(pointsIn(clusters[0]) + pointsIn(clusters[1])), points.size());
    EXPECT_LT(boxOf(clusters[0]).max().x(), static_cast<double>(shift) + 0.45);
    EXPECT_GT(boxOf(clusters[1]).min().x(), static_cast<double>(shift) + 0.7);
  }
}

TEST(PointClusters, PartsAboveOneAnotherBelongTogether) {
  const auto seat = filled({0, 0, 0.4F}, {0.4F, 0.4F, 0.45F});
  const auto back = filled({0.35F, 0, 0.7F}, {0.4F, 0.4F, 0.95F});
  EXPECT_EQ(clustersOf(voxelsOf(both(seat, back)), {}).size(), 1U);
  const auto lamp = filled({0, 0, 1.5F}, {0.4F, 0.4F, 1.8F});
  EXPECT_EQ(clustersOf(voxelsOf(both(seat, lamp)), {}).size(), 2U);
}

TEST(PointClusters, ABoxHoldsItsPointsButForSingleWrongOnes) {
  auto points = filled({0, 0, 0}, {1, 1, 1});
  const PointCluster cluster = voxelsOf(both(points, {{1.4F, 0.5F, 0.5F}})).list;
  const Eigen::AlignedBox3d box = boxOf(cluster);
  // Its sides lie at the means of the outermost voxels, so less than a voxel inside.
  EXPECT_LT(box.min().maxCoeff(), kObjectVoxel);
  EXPECT_GT(box.max().minCoeff(), 1 - kObjectVoxel);
  EXPECT_LT(box.max().x(), 1.1);
}

/// A side that is seen at a flat angle: points of neighbouring pixels, 0.24 m apart in depth.
TEST(PointClusters, NeighboursInTheImageBelongTogether) {
  CameraModel camera;
  camera.width = camera.height = 100;
  camera.fx = camera.fy = 100;
  camera.cx = camera.cy = 50;
  const auto at = [](int u, int v, float depth) {
    return Eigen::Vector3f(static_cast<float>(u - 50) / 100 * depth,
                           static_cast<float>(v - 50) / 100 * depth, depth);
  };
  const auto inMap = [](const std::vector<Eigen::Vector3f>& of_camera) {
    std::vector<Eigen::Vector3f> turned;
    turned.reserve(of_camera.size());
    for (const Eigen::Vector3f& p : of_camera) turned.emplace_back(p.x(), p.z(), -p.y());
    return turned;
  };
  std::vector<Eigen::Vector3f> points;
  for (int v = 40; v < 60; v += 2)
    for (int u = 60; u < 66; u += 2)
      points.push_back(at(u, v, 3 + 0.12F * static_cast<float>(u - 60)));
  EXPECT_GT(clustersOf(voxelsOf(inMap(points)), {}).size(), 1U);
  const std::vector<PointCluster> joined =
      clustersOf(voxelsOf(inMap(points)), neighboursOf(points, camera, 2));
  ASSERT_EQ(joined.size(), 1U);
  EXPECT_EQ(pointsIn(joined[0]), 30);
  EXPECT_EQ(innerPointsIn(joined[0]), 8) << "the middle column without its ends";
  // A thing beside it in the image, but 1 m behind, is another one.
  for (int v = 40; v < 60; v += 2) points.push_back(at(66, v, 4.6F));
  std::stable_sort(points.begin(), points.end(),
                   [](const auto& a, const auto& b) { return a.y() / a.z() < b.y() / b.z(); });
  EXPECT_EQ(clustersOf(voxelsOf(inMap(points)), neighboursOf(points, camera, 2)).size(), 2U);
}

}  // namespace
}  // namespace edge_mcl
