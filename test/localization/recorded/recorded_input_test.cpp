// A rawlog must give the localizer the flight that was written into it.
#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/serialization/CArchive.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/recorded/sequence_input.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "edge_mcl/mrpt_plugins/rawlog_export.h"
#include "edge_mcl/mrpt_plugins/rawlog_input.h"
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

/// The truth is the frames of the simulator.
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
    // The rawlog holds the odometry of the base since the begin of the flight. The simulator gives
    // the odometry of the camera, which is converted here.
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

/// A frame with an image of noise, which does not compress.
RecordedFrame noisy(double time) {
  RecordedFrame frame;
  frame.time = time;
  frame.color = cv::Mat(60, 80, CV_8UC1);
  cv::randu(frame.color, 0, 256);
  return frame;
}

RecordingSetup smallSetup() {
  RecordingSetup setup;
  setup.camera.width = 80;
  setup.camera.height = 60;
  setup.camera.fx = setup.camera.fy = 70;
  setup.camera.cx = 40;
  setup.camera.cy = 30;
  return setup;
}

/// Before close() the file has the name FILE.part. An existing rawlog is never overwritten.
TEST_F(RecordedInputs, ARawlogHasItsNameWhenItIsWhole) {
  const std::string file = (folder_ / "new.rawlog").string();
  {
    RawlogWriter writer(file, smallSetup(), FilterParameters());
    writer.write(noisy(1));
    EXPECT_FALSE(fs::exists(file));
    writer.close();
    EXPECT_TRUE(fs::exists(file));
    EXPECT_FALSE(fs::exists(file + ".part"));
  }
  const auto size = fs::file_size(file);
  EXPECT_THROW(RawlogWriter(file, smallSetup(), FilterParameters()), InputError);
  EXPECT_EQ(fs::file_size(file), size);
  // A rawlog without close(), as after an exception, never gets its name.
  const std::string other = (folder_ / "other.rawlog").string();
  RawlogWriter(other, smallSetup(), FilterParameters()).write(noisy(1));
  EXPECT_FALSE(fs::exists(other));
}

TEST_F(RecordedInputs, ARawlogThatIsCutOffSaysSo) {
  const std::string file = (folder_ / "whole.rawlog").string();
  RawlogWriter writer(file, smallSetup(), FilterParameters());
  for (int k = 0; k < 6; ++k) writer.write(noisy(1 + k));
  writer.close();
  EXPECT_EQ(RawlogInput(file, true, false).damage(), "");
  fs::resize_file(file, fs::file_size(file) * 6 / 10);  // in the middle of the fourth image
  RawlogInput half(file, true, false);
  EXPECT_EQ(half.imageCount(), 3u);
  EXPECT_NE(half.damage().find("cut off after 3 images"), std::string::npos) << half.damage();
  LiveInput input;
  std::string problem;
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(half.next(&input, &problem)) << k;
  EXPECT_FALSE(half.next(&input, &problem));
}

/// MRPT's tools write large recordings as X.rawlog with images in X_Images/. Here one image file is
/// no image, one is missing, and the file of the range image is missing. Each fault is one line.
TEST_F(RecordedInputs, ImagesInFilesOfTheirOwnAreRead) {
  const fs::path images = folder_ / "large_Images";
  fs::create_directories(images);
  cv::imwrite((images / "0.png").string(), noisy(0).color);
  std::ofstream(images / "1.png") << "no image";
  cv::imwrite((images / "3.png").string(), noisy(0).color);
  const std::string file = (folder_ / "large.rawlog").string();
  {
    mrpt::io::CFileGZOutputStream stream(file);
    auto archive = mrpt::serialization::archiveFrom(stream);
    for (int k = 0; k < 4; ++k) {
      mrpt::obs::CObservationImage image;
      image.timestamp = mrpt::Clock::fromDouble(10 + k);
      image.sensorLabel = "camera";
      image.cameraParams = toMrpt(smallSetup().camera);
      image.image.setExternalStorage(std::to_string(k) + ".png");
      archive << image;
    }
    mrpt::obs::CObservation3DRangeScan ranges;
    ranges.timestamp = mrpt::Clock::fromDouble(13.01);
    ranges.sensorLabel = "depth";
    ranges.cameraParams = toMrpt(smallSetup().camera);
    ranges.hasRangeImage = true;
    ranges.rangeImage_setSize(60, 80);
    ranges.rangeImage.fill(1000);
    ranges.rangeImage_convertToExternalStorage("ranges.bin", images.string() + "/");
    archive << ranges;
  }
  fs::remove(images / "ranges.bin");
  RawlogInput rawlog(file, true, true);
  ASSERT_EQ(rawlog.imageCount(), 4u);
  EXPECT_EQ(rawlog.rangeCount(), 1u);
  LiveInput input;
  std::string problem;
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE(rawlog.next(&input, &problem));
    EXPECT_NEAR(input.time, k < 3 ? 10 + k : 13, 0.02);
    const bool readable = k == 0 || k == 3;
    EXPECT_EQ(input.views.size(), readable ? 1u : 0u) << k;
    EXPECT_TRUE(input.depths.empty());
    const std::string bad = k == 0   ? ""
                            : k == 3 ? "large_Images/ranges.bin"
                                     : "large_Images/" + std::to_string(k) + ".png";
    EXPECT_EQ(problem.empty(), bad.empty()) << problem;
    EXPECT_NE(problem.find(bad), std::string::npos) << problem;
    EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
  }
  EXPECT_FALSE(rawlog.next(&input, &problem));
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
