#include "edge_mcl/core/mesh/ray_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/mesh/closest_point.h"
#include "edge_mcl/core/mesh/embree.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::Random;
using test::uniform;

/// An Embree scene that holds one mesh.
class Scene {
 public:
  explicit Scene(const MeshModel& mesh)
      : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
    attachMesh(device_, scene_, mesh);
    rtcCommitScene(scene_);
  }
  ~Scene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;
  RTCSceneTy* get() const { return scene_; }

 private:
  RTCDevice device_;
  RTCScene scene_;
};

/// A wall of 2 x 2 m at x = 1.
MeshModel wall() {
  MeshSoup soup;
  soup.vertices = {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  soup.triangle_material = {0, 0};
  return weldMesh(std::move(soup), 1e-6, "wall");
}

Eigen::Vector3d somewhere(Random* random) {
  return {uniform(random, 0, 8), uniform(random, 0, 5), uniform(random, 0, 2.6)};
}

/// The truth is the depth from a slow ray caster that tries every triangle. The face with the
/// number of the hit must hold this point. The faces themselves are not compared, because furniture
/// stands on the floor, so some faces lie on others.
TEST(AttachMesh, FacesKeepTheirNumbers) {
  const MeshModel mesh = test::furnishedRooms();
  const Scene scene(mesh);
  constexpr double kMetres = 1e-4;  // single precision over 10 m
  Random random(1);
  int differ = 0;
  for (int i = 0; i < 1000; ++i) {
    Pose pose = Pose::Identity();
    pose.translation() = somewhere(&random).cast<float>().cast<double>();
    const Eigen::Vector3d direction =
        test::anywhere(&random).normalized().cast<float>().cast<double>();
    const auto expected = test::PlainRayCaster(mesh, pose).cast(direction);
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(pose.translation().x());
    ray.ray.org_y = static_cast<float>(pose.translation().y());
    ray.ray.org_z = static_cast<float>(pose.translation().z());
    ray.ray.dir_x = static_cast<float>(direction.x());
    ray.ray.dir_y = static_cast<float>(direction.y());
    ray.ray.dir_z = static_cast<float>(direction.z());
    ray.ray.tnear = 0.01f;  // as the slow ray caster
    ray.ray.tfar = INFINITY;
    ray.ray.mask = 0xffffffffu;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    embree::intersect1(scene.get(), &ray);
    const bool hits = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    if (!hits && expected.face < 0) continue;  // out through a wall that is closer than 1 cm
    if (!hits || std::abs(ray.ray.tfar - expected.depth) > kMetres) {
      ++differ;
      continue;
    }
    const Eigen::Vector3d hit = pose.translation() + expected.depth * direction;
    const auto& t = mesh.triangles.at(ray.hit.primID);
    const Eigen::Vector3d on_face = closestPointOnTriangle(hit, mesh.vertices[t[0]].cast<double>(),
                                                           mesh.vertices[t[1]].cast<double>(),
                                                           mesh.vertices[t[2]].cast<double>());
    EXPECT_LT((on_face - hit).norm(), kMetres);
  }
  // Rays that graze an edge may differ in single precision.
  EXPECT_LE(differ, 2);
}

/// The truth is a slow ray caster that tries every triangle.
TEST(IsBlocked, AgreesWithEveryTriangleTriedAlone) {
  const MeshModel mesh = test::furnishedRooms();
  const Scene scene(mesh);
  Random random(2);
  int differ = 0, blocked = 0;
  constexpr int kPairs = 2000;
  for (int i = 0; i < kPairs; ++i) {
    Pose pose = Pose::Identity();
    pose.translation() = somewhere(&random);
    const Eigen::Vector3d to = somewhere(&random), way = to - pose.translation();
    // The slow ray caster ignores the first hundredth of the way.
    const bool expected = test::PlainRayCaster(mesh, pose).cast(way).depth < 1 - 0.02;
    blocked += expected;
    differ += expected != isBlocked(scene.get(), pose.translation().cast<float>(), to.cast<float>(),
                                    0.01f, 0.02f);
  }
  EXPECT_GT(blocked, kPairs / 4);
  EXPECT_LT(blocked, kPairs * 3 / 4);
  // Rays that graze an edge may differ in single precision.
  EXPECT_LE(differ, 4);
}

/// The wall stands at a quarter of a way of 4 m.
TEST(IsBlocked, TheMarginsAreSharesOfTheWay) {
  const Scene scene(wall());
  const Eigen::Vector3f from(0, 0.2f, 0.1f), to(4, 0.2f, 0.1f);
  EXPECT_TRUE(isBlocked(scene.get(), from, to, 0, 0));
  EXPECT_TRUE(isBlocked(scene.get(), from, to, 0.24f, 0));
  EXPECT_FALSE(isBlocked(scene.get(), from, to, 0.26f, 0));
  EXPECT_TRUE(isBlocked(scene.get(), from, to, 0, 0.74f));
  EXPECT_FALSE(isBlocked(scene.get(), from, to, 0, 0.76f));
}

TEST(IsBlocked, OnlySurfacesBetweenThePointsCount) {
  const Scene scene(wall());
  EXPECT_FALSE(isBlocked(scene.get(), {0, 0.2f, 0}, {0.9f, 0.2f, 0}, 0, 0));  // before the wall
  EXPECT_FALSE(isBlocked(scene.get(), {1.1f, 0.2f, 0}, {4, 0.2f, 0}, 0, 0));  // behind it
  EXPECT_FALSE(isBlocked(scene.get(), {0, 1.2f, 0}, {4, 1.2f, 0}, 0, 0));     // beside it
  EXPECT_TRUE(isBlocked(scene.get(), {4, 0.2f, 0}, {0, 0.2f, 0}, 0, 0));      // seen from its back
}

}  // namespace
}  // namespace edge_mcl
