#include "edge_mcl/core/depth/distance_field.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::anywhere;
using test::expectError;
using test::Random;

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

/// The folder is the one for caches of the XDG Base Directory Specification.
TEST_F(StoredField, WithoutACacheFolderItGoesToTheCacheOfTheHomeFolder) {
  const std::string blocked = directory_ + "/file";
  std::ofstream(blocked).put('x');
  unsetenv("XDG_CACHE_HOME");
  const char* const home = std::getenv("HOME");
  const std::string home_before = home ? home : "";
  setenv("HOME", directory_.c_str(), 1);
  storedDistanceField(mesh_, coarse_, blocked + "/rooms.obj", &warning_);
  if (home)
    setenv("HOME", home_before.c_str(), 1);
  else
    unsetenv("HOME");
  EXPECT_EQ(warning_, "");
  EXPECT_TRUE(std::filesystem::is_directory(directory_ + "/.cache/edge_mcl"));
  EXPECT_EQ(files().size(), 2u);
}

TEST_F(StoredField, ErrorsNameTheFileAndTheFault) {
  const DistanceField field(mesh_, coarse_);
  const std::string file = directory_ + "/a.field";
  const auto read = [&] { DistanceField::read(file, 5); };
  expectError<InputError>(file + ": missing", read);
  std::ofstream(file) << "short";
  expectError<InputError>(file + ": not a distance field", read);
  field.write(file, 6);
  expectError<InputError>(file + ": made from another model", read);
  field.write(file, 5);
  EXPECT_NO_THROW(read());
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 4);
  expectError<InputError>(file + ": truncated", read);
  field.write(file, 5);
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(-1, std::ios::end)
      .put('\x55');
  expectError<InputError>(file + ": damaged", read);
  const std::string nowhere = directory_ + "/no_folder/a.field";
  expectError<InputError>(nowhere + ": cannot be written", [&] { field.write(nowhere, 5); });
}

/// A folder cannot be replaced by a file. The incomplete file must not stay behind.
TEST_F(StoredField, WhatCannotGetItsNameLeavesNoFile) {
  const DistanceField field(mesh_, coarse_);
  const std::string taken = directory_ + "/taken";
  std::filesystem::create_directories(taken + "/folder");
  EXPECT_THROW(field.write(taken, 5), InputError);
  EXPECT_TRUE(files().empty());
}

/// Every change of the mesh or of an option gives another hash. The report and the colours of the
/// mesh have no influence on the field.
TEST_F(StoredField, TheHashTellsModelsAndOptionsApart) {
  const uint64_t hash = DistanceField::hashOf(mesh_, coarse_);
  EXPECT_EQ(DistanceField::hashOf(test::furnishedRooms(), coarse_), hash);
  std::set<uint64_t> hashes{hash};
  hashes.insert(DistanceField::hashOf(mesh_, {0.31, 0.1, 256e6}));
  hashes.insert(DistanceField::hashOf(mesh_, {0.3, 0.11, 256e6}));
  hashes.insert(DistanceField::hashOf(mesh_, {0.3, 0.1, 255e6}));
  MeshModel moved = mesh_, turned = mesh_, smaller = mesh_, coloured = mesh_;
  moved.vertices.back().z() += 1e-3f;
  std::swap(turned.triangles.back()[0], turned.triangles.back()[1]);
  smaller.triangles.pop_back();
  for (const MeshModel* mesh : {&moved, &turned, &smaller})
    hashes.insert(DistanceField::hashOf(*mesh, coarse_));
  EXPECT_EQ(hashes.size(), 7u);
  coloured.material_colors.front().setZero();
  coloured.report.warnings.push_back("a warning");
  EXPECT_EQ(DistanceField::hashOf(coloured, coarse_), hash);
}

}  // namespace
}  // namespace edge_mcl
