#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/depth/distance_field.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/mesh/closest_point.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::anywhere;
using test::plainDistance;
using test::Random;
using test::uniform;

std::shared_ptr<const DistanceField> roomField() {
  static const auto field =
      std::make_shared<const DistanceField>(test::furnishedRooms(), DistanceField::Options());
  return field;
}

/// The truth is the closest point of a fine grid on the triangle.
TEST(ClosestPoint, NoPointOfTheTriangleIsCloser) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d a = anywhere(&random), b = anywhere(&random), c = anywhere(&random),
                          p = anywhere(&random, -2, 2);
    const Eigen::Vector3d closest = closestPointOnTriangle(p, a, b, c);
    constexpr int kGrid = 60;
    double least = INFINITY;
    for (int u = 0; u <= kGrid; ++u)
      for (int v = 0; u + v <= kGrid; ++v)
        least = std::min(least, (a + (b - a) * u / kGrid + (c - a) * v / kGrid - p).norm());
    // At least one point of the grid lies within a grid step of the closest point.
    const double step = ((b - a).norm() + (c - a).norm()) / kGrid;
    EXPECT_LE((closest - p).norm(), least + 1e-12);
    EXPECT_GE((closest - p).norm(), least - step);
  }
}

/// The truth is the distance from every face, one by one.
TEST(ClosestFace, IsTheOneThatBruteForceFinds) {
  const MeshModel mesh = test::furnishedRooms();
  const ClosestFace faces(mesh);
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(uniform(&random, -1, 9), uniform(&random, -1, 6),
                            uniform(&random, -1, 3.6));
    const double truth = plainDistance(mesh, p);
    const ClosestFace::Hit hit = faces.find(p, 0.5);
    // The search runs in single precision. At its limit of 0.5 m it may find the face or not.
    if (std::abs(truth - 0.5) > 1e-5) {
      EXPECT_EQ(hit.found, truth < 0.5);
    }
    if (hit.found) {
      EXPECT_NEAR(hit.distance, truth, 1e-6);
    }
  }
}

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

class StoredField : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = testing::TempDir() + "stored_field_" + std::to_string(getpid());
    std::filesystem::create_directories(directory_ + "/model");
    setenv("XDG_CACHE_HOME", (directory_ + "/cache").c_str(), 1);
  }
  void TearDown() override {
    unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(directory_);
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& f : std::filesystem::recursive_directory_iterator(directory_))
      if (f.is_regular_file()) names.push_back(f.path().string());
    return names;
  }
  std::string directory_, warning_;
  MeshModel mesh_ = test::furnishedRooms();
  DistanceField::Options coarse_{0.3, 0.1, 256e6};
};

TEST_F(StoredField, ComesBackAsItWas) {
  const std::string model = directory_ + "/model/rooms.obj";
  const DistanceField made = storedDistanceField(mesh_, coarse_, model, &warning_);
  ASSERT_EQ(files().size(), 1u);
  EXPECT_EQ(files()[0].rfind(model + ".", 0), 0u) << files()[0];
  const auto time = std::filesystem::last_write_time(files()[0]);
  const DistanceField read = storedDistanceField(mesh_, coarse_, model, &warning_);
  EXPECT_EQ(std::filesystem::last_write_time(files()[0]), time);
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p = anywhere(&random, 0, 5);
    EXPECT_EQ(made.at(p).near, read.at(p).near);
    EXPECT_EQ(made.at(p).distance, read.at(p).distance);
  }
  // Another truncation or another mesh needs another field.
  storedDistanceField(mesh_, {0.2, 0.1, 256e6}, model, &warning_);
  mesh_.vertices[0].x() -= 0.01f;
  storedDistanceField(mesh_, coarse_, model, &warning_);
  EXPECT_EQ(files().size(), 3u);
  EXPECT_EQ(warning_, "");
}

TEST_F(StoredField, ADamagedFileIsMadeAnew) {
  const std::string model = directory_ + "/model/rooms.obj";
  const DistanceField made = storedDistanceField(mesh_, coarse_, model, &warning_);
  const std::string file = files().at(0);
  const uint64_t hash = DistanceField::hashOf(mesh_, coarse_);
  const auto size = std::filesystem::file_size(file);
  EXPECT_THROW(DistanceField::read(file, hash + 1), InputError);
  for (const size_t length : {size - 1, size / 2, size_t{60}, size_t{0}}) {
    std::filesystem::resize_file(file, length);
    EXPECT_THROW(DistanceField::read(file, hash), InputError) << length;
    storedDistanceField(mesh_, coarse_, model, &warning_);
    EXPECT_EQ(std::filesystem::file_size(file), size);
  }
  // Positions in the origin, the truncation, the bricks and the voxels.
  for (const int at : {50, 75, 85, 5000}) {
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(at).put('\x55');
    EXPECT_THROW(DistanceField::read(file, hash), InputError) << at;
    std::filesystem::remove(file);
    storedDistanceField(mesh_, coarse_, model, &warning_);
  }
}

TEST_F(StoredField, GoesToTheCacheOrNowhere) {
  // The folder of the model is a file, so nothing can be written there. A write-protected folder
  // would not do, because root can write to it.
  const std::string blocked = directory_ + "/file";
  std::ofstream(blocked).put('x');
  storedDistanceField(mesh_, coarse_, blocked + "/rooms.obj", &warning_);
  EXPECT_EQ(warning_, "");
  ASSERT_EQ(files().size(), 2u);
  setenv("XDG_CACHE_HOME", (blocked + "/cache").c_str(), 1);
  storedDistanceField(mesh_, coarse_, blocked + "/rooms.obj", &warning_);
  EXPECT_NE(warning_.find("computed at every start"), std::string::npos);
}

}  // namespace
}  // namespace edge_mcl
