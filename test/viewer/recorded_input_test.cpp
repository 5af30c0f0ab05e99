// The same flight as a directory and as a rawlog is the same to the localizer.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "edge_mcl/core/error.h"
#include "edge_mcl/core/sequence.h"
#include "edge_mcl/mrpt_plugins/rawlog_export.h"
#include "edge_mcl/mrpt_plugins/rawlog_input.h"
#include "edge_mcl/mrpt_plugins/sequence_input.h"
#include "edge_mcl/sim/sequence_writer.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

class RecordedInputs : public testing::Test {
 protected:
  RecordedInputs() : folder_(fs::temp_directory_path() / ("inputs_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~RecordedInputs() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(RecordedInputs, ARawlogHoldsTheFlight) {
  const Scenario scenario =
      Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml");
  Simulator simulator(scenario);
  RecordingSetup setup = simulator.setup();
  const std::string file = (folder_ / "flight.rawlog").string();
  RawlogWriter writer(file, setup, FilterParameters());
  std::vector<RecordedFrame> frames(6);
  for (RecordedFrame& frame : frames) {
    simulator.next(&frame);
    writer.write(frame);
  }
  writer.close();

  RawlogInput rawlog(file, true, false);
  EXPECT_EQ(rawlog.imageCount(), frames.size());
  EXPECT_EQ(rawlog.truth().size(), frames.size());
  EXPECT_FALSE(rawlog.initialPose());
  LiveInput input;
  std::string problem;
  std::optional<Pose> first;
  for (const RecordedFrame& frame : frames) {
    ASSERT_TRUE(rawlog.next(&input, &problem));
    EXPECT_EQ(problem, "");
    EXPECT_NEAR(input.time, frame.time, 1e-6);
    ASSERT_EQ(input.views.size(), 1u);
    EXPECT_EQ(input.views[0].image.size(), frame.color.size());
    EXPECT_EQ(input.views[0].mask.empty(), frame.mask.empty());
    EXPECT_TRUE(input.views[0].T_base_camera.isApprox(setup.T_base_camera, 1e-6));
    // Odometry of the base, from the flight's begin; that of the recording is the camera's.
    ASSERT_TRUE(input.odometry);
    if (!first) first = input.odometry;
    const Pose moved = frames[0].odometry->inverse() * *frame.odometry;
    const Pose of_base = setup.T_base_camera * moved * setup.T_base_camera.inverse();
    EXPECT_LT((first->inverse() * *input.odometry * of_base.inverse()).translation().norm(), 1e-5);
    EXPECT_LT(rotationAngle(first->inverse() * *input.odometry, of_base), 1e-5);
  }
  EXPECT_FALSE(rawlog.next(&input, &problem));

  RawlogInput without(file, false, false);
  ASSERT_TRUE(without.next(&input, &problem));
  EXPECT_TRUE(input.views[0].mask.empty());
}

TEST_F(RecordedInputs, WhatIsNoRawlogIsSaid) {
  EXPECT_THROW(RawlogInput("/nonexistent.rawlog", true, false), InputError);
  const std::string file = (folder_ / "text.rawlog").string();
  std::ofstream(file) << "this is no rawlog, but a text that is long enough to be read as one\n";
  EXPECT_THROW(RawlogInput(file, true, false), InputError);
  std::ofstream(file, std::ios::trunc).flush();
  EXPECT_THROW(RawlogInput(file, true, false), InputError);
}

}  // namespace
}  // namespace edge_mcl
