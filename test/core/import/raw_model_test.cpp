#include "edge_mcl/core/import/raw_model.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>

namespace edge_mcl {
namespace {

using OpenFile = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

RawModel example() {
  RawModel model;
  model.vertices = {{0, 0, 0}, {1, 0.1, 0}, {0, 1, 5428765.432}};
  model.triangles = {{0, 1, 2}};
  model.triangle_material = {1};
  model.triangle_object = {0};
  model.lines = {{0, 2}};
  model.line_object = {1};
  model.material_colors = {{1, 0, 0}, {0, 0.5f, 1}};
  model.objects = {"wall", ""};
  model.unit = 0.3048;
  model.unit_name = "foot";
  model.up_axis = 1;
  model.in_metres = true;
  model.rounding = {1e-4f, 0, 3};
  model.empty_faces = 7;
  return model;
}

TEST(RawModel, ReadsWhatItHasWritten) {
  const OpenFile file(std::tmpfile(), &std::fclose);
  const RawModel written = example();
  ASSERT_TRUE(writeRawModel(written, file.get()));
  std::rewind(file.get());
  RawModel read;
  ASSERT_TRUE(readRawModel(file.get(), &read));
  EXPECT_EQ(read.vertices, written.vertices);
  EXPECT_EQ(read.triangles, written.triangles);
  EXPECT_EQ(read.triangle_material, written.triangle_material);
  EXPECT_EQ(read.triangle_object, written.triangle_object);
  EXPECT_EQ(read.lines, written.lines);
  EXPECT_EQ(read.line_object, written.line_object);
  EXPECT_EQ(read.material_colors, written.material_colors);
  EXPECT_EQ(read.objects, written.objects);
  EXPECT_EQ(read.unit, written.unit);
  EXPECT_EQ(read.unit_name, written.unit_name);
  EXPECT_EQ(read.up_axis, written.up_axis);
  EXPECT_EQ(read.in_metres, written.in_metres);
  EXPECT_EQ(read.rounding, written.rounding);
  EXPECT_EQ(read.empty_faces, written.empty_faces);
}

/// A process that is killed leaves a file that is cut off anywhere.
TEST(RawModel, DataThatAreCutOffAreRefused) {
  const OpenFile file(std::tmpfile(), &std::fclose);
  ASSERT_TRUE(writeRawModel(example(), file.get()));
  for (long size = std::ftell(file.get()) - 1; size >= 0; --size) {
    ASSERT_EQ(ftruncate(fileno(file.get()), size), 0);
    std::rewind(file.get());
    RawModel read;
    EXPECT_FALSE(readRawModel(file.get(), &read)) << size;
  }
}

TEST(RawModel, NumbersBeyondTheirListsAreRefused) {
  for (const int fault : {0, 1, 2, 3}) {
    RawModel model = example();
    if (fault == 0) model.triangles[0][1] = 3;
    if (fault == 1) model.lines[0][1] = 3;
    if (fault == 2) model.triangle_material[0] = 2;
    if (fault == 3) model.line_object.clear();
    const OpenFile file(std::tmpfile(), &std::fclose);
    ASSERT_TRUE(writeRawModel(model, file.get()));
    std::rewind(file.get());
    RawModel read;
    EXPECT_FALSE(readRawModel(file.get(), &read)) << fault;
  }
}

}  // namespace
}  // namespace edge_mcl
