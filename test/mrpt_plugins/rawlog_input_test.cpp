// A rawlog must give the localizer the flight that was written into it.
#include "edge_mcl/mrpt_plugins/rawlog_input.h"

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "edge_mcl/mrpt_plugins/rawlog_export.h"
#include "edge_mcl/sim/simulator.h"
#include "support/error_text.h"
#include "support/small_rawlog.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;
using test::noisy;
using test::smallSetup;

class RawlogInputTest : public test::WithFolder {};

/// The truth is the frames of the simulator.
TEST_F(RawlogInputTest, ARawlogHoldsTheFlight) {
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
    ASSERT_EQ(input.images.size(), 1u);
    EXPECT_EQ(input.images[0].image.size(), frame.color.size());
    EXPECT_EQ(input.images[0].mask.empty(), frame.mask.empty());
    EXPECT_TRUE(input.images[0].T_base_camera.isApprox(setup.T_base_camera, 1e-6));
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
  EXPECT_TRUE(input.images[0].mask.empty());
}

TEST_F(RawlogInputTest, ARawlogThatIsCutOffSaysSo) {
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
TEST_F(RawlogInputTest, ImagesInFilesOfTheirOwnAreRead) {
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
    EXPECT_EQ(input.images.size(), readable ? 1u : 0u) << k;
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

TEST_F(RawlogInputTest, WhatIsNoRawlogIsSaid) {
  EXPECT_THROW(RawlogInput("/nonexistent.rawlog", true, false), InputError);
  const std::string file = (folder_ / "text.rawlog").string();
  std::ofstream(file) << "this is no rawlog, but a text that is long enough to be read as one\n";
  EXPECT_THROW(RawlogInput(file, true, false), InputError);
  std::ofstream(file, std::ios::trunc).flush();
  EXPECT_THROW(RawlogInput(file, true, false), InputError);
}

/// Writes single observations to a rawlog, as MRPT's programs for recording do.
class ObservationWriter {
 public:
  explicit ObservationWriter(const std::string& file) : stream_(file) {}
  void write(const mrpt::serialization::CSerializable& object) {
    mrpt::serialization::archiveFrom(stream_) << object;
  }
  void writeImage(double time, int grey, bool calibrated = true) {
    mrpt::obs::CObservationImage image;
    image.timestamp = mrpt::Clock::fromDouble(time);
    image.sensorLabel = "camera";
    if (calibrated)
      image.cameraParams = toMrpt(smallSetup().camera);
    else
      image.cameraParams.setIntrinsicParamsFromValues(0, 0, 0, 0);
    image.image =
        mrpt::img::CImage(cv::Mat(60, 80, CV_8UC1, cv::Scalar(grey)), mrpt::img::DEEP_COPY);
    write(image);
  }
  void writeRanges(double time, uint16_t millimetres) {
    mrpt::obs::CObservation3DRangeScan ranges;
    ranges.timestamp = mrpt::Clock::fromDouble(time);
    ranges.sensorLabel = "depth";
    ranges.cameraParams = toMrpt(smallSetup().camera);
    ranges.hasRangeImage = true;
    ranges.rangeImage_setSize(60, 80);
    ranges.rangeImage.fill(millimetres);
    write(ranges);
  }
  void writeOdometry(double x, double yaw) {
    mrpt::obs::CObservationOdometry odometry;
    odometry.odometry = {x, 0, yaw};
    write(odometry);
  }
  void writeTruth(double time, double x) {
    mrpt::obs::CObservationRobotPose pose;
    pose.timestamp = mrpt::Clock::fromDouble(time);
    pose.pose.mean = mrpt::poses::CPose3D(x, 0, 0, 0, 0, 0);
    write(pose);
  }
  /// An action with a rotation. @param yaw rad
  void writeMotion(double x, double yaw) {
    mrpt::obs::CActionRobotMovement3D movement;
    movement.poseChange.mean = mrpt::poses::CPose3D(x, 0, 0, yaw, 0, 0);
    mrpt::obs::CActionCollection actions;
    actions.insert(movement);
    write(actions);
  }

 private:
  mrpt::io::CFileGZOutputStream stream_;
};

TEST_F(RawlogInputTest, SingleObservationsMakeMoments) {
  {
    ObservationWriter writer(path("single.rawlog"));
    writer.writeOdometry(1, 0.1);
    writer.writeTruth(10.2, 6);  // the truth need not be in the order of time
    writer.writeTruth(10.0, 5);
    writer.writeImage(10.0, 11);
    writer.writeOdometry(2, 0.2);
    writer.writeImage(10.2, 22);
  }
  RawlogInput rawlog(path("single.rawlog"), true, false);
  EXPECT_EQ(rawlog.imageCount(), 2u);
  EXPECT_EQ(rawlog.rangeCount(), 0u);
  EXPECT_EQ(rawlog.damage(), "");
  ASSERT_EQ(rawlog.truth().size(), 2u);
  EXPECT_NEAR(rawlog.truth()[0].time, 10, 1e-6);
  EXPECT_EQ(rawlog.truth()[0].pose.translation().x(), 5);
  EXPECT_EQ(rawlog.truth()[1].pose.translation().x(), 6);
  LiveInput input;
  std::string problem;
  for (const int k : {1, 2}) {
    ASSERT_TRUE(rawlog.next(&input, &problem));
    EXPECT_EQ(problem, "");
    EXPECT_NEAR(input.time, 9.8 + 0.2 * k, 1e-6);
    EXPECT_EQ(input.images.at(0).image.at<uint8_t>(0, 0), 11 * k);
    Pose expected = Pose::Identity();
    expected.translation().x() = k;
    expected.linear() = rotationFromAngles(0, 0, 0.1 * k);
    ASSERT_TRUE(input.odometry);
    EXPECT_TRUE(input.odometry->isApprox(expected, 1e-9));
  }
  EXPECT_FALSE(rawlog.next(&input, &problem));
}

/// The two sensors have the same time, to some milliseconds, for the first and the last image. The
/// second image has no range image, and the third range image has no image.
TEST_F(RawlogInputTest, AnImageAndARangeImageOfOneTimeMakeAMoment) {
  {
    ObservationWriter writer(path("both.rawlog"));
    writer.writeImage(10.000, 1);
    writer.writeRanges(10.005, 1000);
    writer.writeImage(10.100, 2);
    writer.writeRanges(10.200, 3000);
    writer.writeRanges(10.305, 4000);  // before its image
    writer.writeImage(10.300, 4);
  }
  RawlogInput rawlog(path("both.rawlog"), true, true);
  EXPECT_EQ(rawlog.imageCount(), 3u);
  EXPECT_EQ(rawlog.rangeCount(), 3u);
  LiveInput input;
  std::string problem;
  for (const int k : {1, 2, 4}) {
    ASSERT_TRUE(rawlog.next(&input, &problem)) << k;
    EXPECT_EQ(problem, "");
    EXPECT_NEAR(input.time, 9.9 + 0.1 * (k == 4 ? 4 : k), 1e-6);
    ASSERT_EQ(input.images.size(), 1u);
    EXPECT_EQ(input.images[0].image.at<uint8_t>(0, 0), k);
    ASSERT_EQ(input.depths.size(), k == 2 ? 0u : 1u) << k;
    if (k != 2) {
      EXPECT_EQ(input.depths[0].image.depth.at<uint16_t>(0, 0), 1000 * k);
    }
  }
  EXPECT_FALSE(rawlog.next(&input, &problem));
}

TEST_F(RawlogInputTest, WithoutImagesEveryRangeImageMakesAMoment) {
  {
    ObservationWriter writer(path("ranges.rawlog"));
    writer.writeRanges(10, 1000);
    writer.writeRanges(11, 2000);
  }
  RawlogInput rawlog(path("ranges.rawlog"), true, true);
  EXPECT_EQ(rawlog.imageCount(), 2u);
  LiveInput input;
  std::string problem;
  for (const int k : {1, 2}) {
    ASSERT_TRUE(rawlog.next(&input, &problem));
    EXPECT_NEAR(input.time, 9 + k, 1e-6);
    EXPECT_TRUE(input.images.empty());
    EXPECT_EQ(input.depths.at(0).image.depth.at<uint16_t>(0, 0), 1000 * k);
  }
  EXPECT_FALSE(rawlog.next(&input, &problem));
  test::expectError<InputError>("there are no images",
                                [&] { RawlogInput(path("ranges.rawlog"), true, false); });
}

TEST_F(RawlogInputTest, AGivenCameraServesImagesWithoutACalibration) {
  {
    ObservationWriter writer(path("bare.rawlog"));
    writer.writeImage(10, 1, false);
    writer.writeImage(11, 2);
  }
  LiveInput input;
  std::string problem;
  RawlogInput without(path("bare.rawlog"), true, false);
  ASSERT_TRUE(without.next(&input, &problem));
  EXPECT_TRUE(input.images.empty());
  EXPECT_PRED2(test::contains, problem, "no calibration");
  ASSERT_TRUE(without.next(&input, &problem));
  EXPECT_EQ(input.images.size(), 1u);

  CameraModel camera = smallSetup().camera;
  camera.fx = 99;
  RawlogInput with(path("bare.rawlog"), true, false, camera);
  ASSERT_TRUE(with.next(&input, &problem));
  EXPECT_EQ(problem, "");
  EXPECT_EQ(input.images.at(0).camera.fx, 99);
  ASSERT_TRUE(with.next(&input, &problem));
  EXPECT_EQ(input.images.at(0).camera.fx, 70);  // this image has its own
}

/// MRPT's rosbag2rawlog writes actions with wild rotations for a robot that flies sideways.
TEST_F(RawlogInputTest, OdometryThatMostlyTurnsWildlyIsNotUsed) {
  for (const int wild : {1, 3}) {
    const std::string file = path(std::to_string(wild) + ".rawlog");
    {
      ObservationWriter writer(file);
      for (int k = 0; k < 4; ++k) {
        writer.writeMotion(0.1, k < wild ? 0.6 : 0.01);
        writer.writeImage(10 + k, k);
      }
    }
    RawlogInput rawlog(file, true, false);
    LiveInput input;
    std::string problem;
    for (int k = 0; k < 4; ++k) {
      ASSERT_TRUE(rawlog.next(&input, &problem));
      EXPECT_EQ(input.odometry.has_value(), wild == 1);
      // The reason is told once.
      EXPECT_EQ(problem.empty(), wild == 1 || k > 0) << problem;
      if (!problem.empty()) {
        EXPECT_PRED2(test::contains, problem, "odometry is not used");
      }
    }
  }
}

}  // namespace
}  // namespace edge_mcl
