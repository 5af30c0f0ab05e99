#include "edge_mcl/core/places/prepared_places.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bitset>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"
#include "support/error_text.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::expectError;

class PreparedPlacesTest : public testing::Test {
 protected:
  static Parameters parameters() {
    Parameters params;
    params.search.prepared_spacing = 0.5;
    return params;
  }
  PreparedPlaces make() const {
    return {*map_.freeSpace(), map_.visibility(), map_.params().search,
            *buildingAxes(map_.edges())};
  }
  LocalizationMap map_{test::furnishedRooms(), parameters()};
  double tolerance_ = map_.visibility().occlusionTolerance();
};

/// Every line along an axis that a camera sees near a place must be in the rows of the place: seen
/// from the camera, not from the place, which is what the width of the lines is for.
TEST_F(PreparedPlacesTest, HoldWhatIsSeenNearby) {
  const PreparedPlaces places = make();
  ASSERT_GT(places.count(), 50u);
  test::Random random(3);
  size_t samples = 0, held = 0;
  for (size_t place = 0; place < places.count(); place += 11) {
    const Eigen::Vector3d offset = test::anywhere(&random, -0.15, 0.15);
    const Eigen::Vector3d eye = places.position(place).cast<double>() + offset;
    const VisibleSet visible = map_.visibility().exact(eye);
    for (const VisibleSet::Segment& s : visible.segments) {
      const EdgeSegment& segment = visible.edgeSegment(s);
      const Eigen::Vector3d tangent =
          places.axes().R_map_building.transpose() * visible.line(s).tangent().cast<double>();
      int axis = 0;
      if (tangent.cwiseAbs().maxCoeff(&axis) < 0.999) continue;
      for (uint32_t i = 0; i < segment.sample_count; ++i) {
        if ((s.samples >> i & 1) == 0) continue;
        const Eigen::Vector3d at = places.axes().R_map_building.transpose() *
                                   (map_.edges().samplePosition(segment, i) - eye);
        const double along = raster::alongOf(at, axis);
        ++samples;
        held +=
            (places.rows(place, axis)[raster::rowOf(at, axis)] & raster::bitsOf(along, along)) != 0
                ? 1
                : 0;
      }
    }
  }
  ASSERT_GT(samples, 1000u);
  // Lines that the place itself does not see, behind a table or a doorway, are missing.
  EXPECT_GT(static_cast<double>(held) / static_cast<double>(samples), 0.9);
}

TEST_F(PreparedPlacesTest, LeaveMostDirectionsOpen) {
  const PreparedPlaces places = make();
  size_t set = 0;
  for (size_t place = 0; place < places.count(); ++place)
    for (int axis = 0; axis < 3; ++axis)
      for (int row = 0; row < raster::kAround; ++row)
        set += std::bitset<64>(places.rows(place, axis)[row]).count();
  // A place that sees lines everywhere would explain every image.
  EXPECT_LT(static_cast<double>(set), 0.4 * static_cast<double>(8 * places.bytes()));
}

TEST_F(PreparedPlacesTest, KeepToTheirMemory) {
  Parameters params = parameters();
  params.search.prepared_spacing = 0.1;
  params.search.prepared_megabytes = 2;
  const LocalizationMap map(test::furnishedRooms(), params);
  const auto places = map.preparedPlaces();
  ASSERT_TRUE(places);
  EXPECT_LE(places->bytes(), 2000000u);
  EXPECT_GT(places->spacing(), 0.2);
}

TEST_F(PreparedPlacesTest, AreNotMadeWhereTheyAreNotWanted) {
  Parameters params = parameters();
  params.search.prepared = false;
  EXPECT_FALSE(LocalizationMap(test::furnishedRooms(), params).preparedPlaces());
}

class StoredPlaces : public PreparedPlacesTest {
 protected:
  void SetUp() override {
    directory_ = testing::TempDir() + "stored_places_" + std::to_string(getpid());
    std::filesystem::create_directories(directory_);
    setenv("XDG_CACHE_HOME", (directory_ + "/cache").c_str(), 1);
  }
  void TearDown() override {
    unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(directory_);
  }
  std::string directory_;
};

TEST_F(StoredPlaces, ComeBackAsTheyWere) {
  const uint64_t hash =
      PreparedPlaces::hashOf(map_.mesh(), map_.edges(), map_.params().search, tolerance_);
  int made = 0;
  const auto stored = [&] {
    return storedPreparedPlaces(directory_ + "/rooms.obj", hash, [&] { return ++made, make(); });
  };
  const PreparedPlaces first = stored(), second = stored();
  EXPECT_EQ(made, 1);
  ASSERT_EQ(first.count(), second.count());
  EXPECT_EQ(first.spacing(), second.spacing());
  EXPECT_TRUE(first.axes().R_map_building == second.axes().R_map_building);
  for (size_t place = 0; place < first.count(); ++place) {
    EXPECT_TRUE(first.position(place) == second.position(place));
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_TRUE(std::equal(first.rows(place, axis), first.rows(place, axis) + raster::kAround,
                             second.rows(place, axis)));
  }
}

TEST_F(StoredPlaces, OtherModelsAndOptionsNeedOthers) {
  const auto hashOf = [&](const SearchParameters& p) {
    return PreparedPlaces::hashOf(map_.mesh(), map_.edges(), p, tolerance_);
  };
  SearchParameters p = map_.params().search;
  const uint64_t hash = hashOf(p);
  p.clearance += 0.1;
  EXPECT_NE(hashOf(p), hash);
  MeshModel mesh = test::furnishedRooms();
  mesh.vertices[0].x() -= 0.01f;
  EXPECT_NE(PreparedPlaces::hashOf(mesh, map_.edges(), map_.params().search, tolerance_), hash);
}

TEST_F(StoredPlaces, BrokenFilesAreErrors) {
  const PreparedPlaces places = make();
  const std::string file = directory_ + "/a.places";
  const auto read = [&] { PreparedPlaces::read(file, 5); };
  expectError<InputError>(file + ": missing", read);
  std::ofstream(file) << "short";
  expectError<InputError>(file + ": not a file of prepared places", read);
  places.write(file, 6);
  expectError<InputError>(file + ": made from another model", read);
  places.write(file, 5);
  EXPECT_NO_THROW(read());
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(-1, std::ios::end)
      .put('\x55');
  expectError<InputError>(file + ": damaged", read);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  expectError<InputError>(file + ": truncated", read);
}

}  // namespace
}  // namespace edge_mcl
