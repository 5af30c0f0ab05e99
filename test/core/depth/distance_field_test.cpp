#include "edge_mcl/core/depth/distance_field.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"
#include "support/depth_scenes.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::plainDistance;
using test::Random;
using test::roomField;
using test::uniform;

/// The truth is the distance from every face, one by one.
TEST(DistanceField, ReadsTheTrueDistance) {
  const MeshModel mesh = test::furnishedRooms();
  const auto field = roomField();
  const double voxel = field->voxelSize(), step = (0.3 + voxel) / 254;
  Random random(3);
  std::vector<double> errors;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(uniform(&random, -0.5, 8.5), uniform(&random, -0.5, 5.5),
                            uniform(&random, -0.5, 3.1));
    const double truth = plainDistance(mesh, p);
    const DistanceField::Reading reading = field->at(p);
    // A reading is made at the centre of a voxel, which is at most half a diagonal away.
    const double half_diagonal = std::sqrt(3.0) / 2 * voxel;
    if (truth < 0.3 + voxel - half_diagonal) {
      ASSERT_TRUE(reading.near) << truth;
    }
    if (truth > 0.3 + voxel + half_diagonal) {
      ASSERT_FALSE(reading.near) << truth;
    }
    if (!reading.near) continue;
    // The distance and its linear continuation both change by at most a metre per metre.
    EXPECT_LE(std::abs(std::abs(reading.distance) - truth), 2 * half_diagonal + 2 * step);
    errors.push_back(std::abs(std::abs(reading.distance) - truth));
  }
  ASSERT_GT(errors.size(), 5000u);
  // Most points lie beside planes, where only rounding is left: half a step of the distance, plus
  // half a 127th of each of the three parts of the gradient over half a voxel.
  std::sort(errors.begin(), errors.end());
  const double rounding = step / 2 + 3 * voxel / 2 / 254;
  EXPECT_LT(errors[errors.size() / 2], rounding);
  EXPECT_LT(errors[errors.size() * 8 / 10], 1.01 * rounding);
}

TEST(DistanceField, HasNoHolesFarFromTheOrigin) {
  // A wall of many small faces stands where single precision is coarse. The truth is the distance
  // from the plane of the wall.
  for (const float at : {40.0f, 1000.0f}) {
    MeshSoup soup;
    constexpr int kCells = 40;
    for (int z = 0; z <= kCells; ++z)
      for (int y = 0; y <= kCells; ++y)
        soup.vertices.emplace_back(at, at + 0.05f * static_cast<float>(y),
                                   0.05f * static_cast<float>(z));
    for (uint32_t z = 0; z < kCells; ++z)
      for (uint32_t y = 0; y < kCells; ++y) {
        const uint32_t corner = z * (kCells + 1) + y, above = corner + kCells + 1;
        soup.triangles.push_back({corner, corner + 1, above});
        soup.triangles.push_back({above, corner + 1, above + 1});
      }
    soup.triangle_material.assign(soup.triangles.size(), 0);
    const DistanceField field(weldMesh(std::move(soup), 1e-4, "wall"), DistanceField::Options());
    Random random(11);
    for (int i = 0; i < 5000; ++i) {
      const double away = uniform(&random, -0.3, 0.3);
      const DistanceField::Reading reading = field.at(
          {static_cast<double>(at) + away, static_cast<double>(at) + uniform(&random, 0.3, 1.7),
           uniform(&random, 0.3, 1.7)});
      ASSERT_TRUE(reading.near) << at << " " << away;
      EXPECT_NEAR(std::abs(reading.distance), std::abs(away), 0.002);
    }
  }
}

TEST(DistanceField, OutsideAndNotFiniteIsFar) {
  EXPECT_FALSE(roomField()->at({100, 0, 0}).near);
  EXPECT_FALSE(roomField()->at({-100, 2, 1}).near);
  EXPECT_FALSE(roomField()->at({NAN, 2, 1}).near);
  EXPECT_FALSE(roomField()->at({4, 2.5, INFINITY}).near);
}

/// A hangar of 900 x 700 x 300 m with a limit of 4 MB.
TEST(DistanceField, ALargeModelGetsLargerVoxelsNotMoreMemory) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {900, 700, 300}, 0, true);
  const DistanceField field(weldMesh(std::move(soup), 1e-3, "hangar"), {0.3, 0, 4e6});
  EXPECT_LE(field.size(), 8e6);  // at most 4e6 for the bricks and 4e6 for the grid of bricks
  EXPECT_GT(field.voxelSize(), 0.04);
  EXPECT_TRUE(field.at({450, 350, 0.2}).near);
  EXPECT_NEAR(std::abs(field.at({450, 350, 0.2}).distance), 0.2, 0.01);
}

TEST(DistanceField, AModelWithoutFacesIsAnError) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}};
  soup.lines = {{0, 1}};
  const MeshModel lines = weldMesh(std::move(soup), 1e-6, "lines");
  EXPECT_THROW(DistanceField(lines, {}), InputError);
  Parameters params;
  params.likelihood.cues = Cues::kBoth;
  EXPECT_THROW(LocalizationMap(lines, params), InputError);
}

}  // namespace
}  // namespace edge_mcl
