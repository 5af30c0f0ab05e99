// Tests the camera class with the real OpenNI2 runtime and the driver in rendered_driver.cpp.
#include <OpenNI.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <random>
#include <thread>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/openni2/device_clock.h"
#include "edge_mcl/nodes/openni2/openni2_camera.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {
namespace {

using Event = OpenNi2Camera::Event;

DepthCameraOptions small() {
  DepthCameraOptions options;
  options.color_width = options.depth_width = 320;
  options.color_height = options.depth_height = 240;
  options.color_fps = options.depth_fps = 15;
  return options;
}

/// Waits for the first frame of a kind, at most some seconds.
OpenNi2Camera::Frame firstOf(OpenNi2Camera* camera, bool depth) {
  OpenNi2Camera::Frame frame;
  for (int i = 0; i < 200; ++i)
    if (camera->read(&frame, 100) == Event::kFrame && frame.is_depth == depth) return frame;
  ADD_FAILURE() << "no frame";
  return frame;
}

std::string messageOf(const DepthCameraOptions& options) {
  try {
    OpenNi2Camera camera(options);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

/// All frames of the flight that the driver shows.
std::vector<RecordedFrame> flight() {
  Simulator simulator(Scenario::fromYamlFile(std::getenv("EDGE_MCL_DRIVER_SCENARIO")));
  std::vector<RecordedFrame> frames;
  RecordedFrame frame;
  for (int i = 0; i < 40 && simulator.next(&frame); ++i)
    frames.push_back({frame.time, frame.color.clone(), frame.depth.clone(), {}, {}, {}});
  return frames;
}

bool isSame(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

/// The truth is the frames of the simulator, which the driver shows. Pixels must be equal.
TEST(OpenNi2Camera, StreamsWhatTheDriverRenders) {
  const std::vector<RecordedFrame> truth = flight();
  OpenNi2Camera camera(small());
  EXPECT_TRUE(camera.hasColor() && camera.hasDepth() && camera.isRegistered());
  EXPECT_NE(camera.description().find("rendered flight"), std::string::npos);
  EXPECT_NE(camera.description().find("registered depth 320x240@15"), std::string::npos);
  const Scenario scenario = Scenario::fromYamlFile(std::getenv("EDGE_MCL_DRIVER_SCENARIO"));
  for (const CameraModel& model : {camera.colorModel(), camera.depthModel()}) {
    EXPECT_EQ(model.width, 320);
    // The driver reports fields of view in single precision.
    EXPECT_NEAR(model.fx, scenario.camera.fx, 1e-3);
    EXPECT_NEAR(model.fy, scenario.camera.fy, 1e-3);
  }
  int colors = 0, depths = 0;
  double last_time[2] = {-1, -1};
  for (int i = 0; i < 300 && colors + depths < 16; ++i) {
    OpenNi2Camera::Frame frame;
    if (camera.read(&frame, 100) != Event::kFrame) continue;
    EXPECT_GT(frame.device_time, last_time[frame.is_depth]);
    last_time[frame.is_depth] = frame.device_time;
    const auto number = static_cast<size_t>(std::lround(frame.device_time * 15));
    if (number >= truth.size()) break;  // on a slow machine the flight is over
    cv::Mat expected;
    if (frame.is_depth)
      truth[number].depth.convertTo(expected, CV_16U, 1000 / scenario.depth_scale);
    else
      cv::cvtColor(truth[number].color, expected, cv::COLOR_BGR2RGB);
    EXPECT_TRUE(isSame(frame.pixels, expected)) << number << (frame.is_depth ? " depth" : "");
    ++(frame.is_depth ? depths : colors);
  }
  EXPECT_GE(colors, 2);
  EXPECT_GE(depths, 2);
}

TEST(OpenNi2Camera, OpensByUriAndBySerialAndSaysWhatIsThere) {
  ASSERT_EQ(OpenNi2Camera::devices().size(), 1u);
  DepthCameraOptions options = small();
  for (const char* name : {"rendered://flight", "RENDERED-0001"}) {
    options.device = name;
    options.color = false;
    OpenNi2Camera camera(options);
    EXPECT_FALSE(camera.hasColor());
    EXPECT_FALSE(camera.isRegistered());  // there is no colour image to register the depth to
    EXPECT_EQ(firstOf(&camera, true).pixels.type(), CV_16UC1);
    EXPECT_THROW(camera.colorModel(), Error);
  }
  options.device = "SERIAL-2";
  EXPECT_EQ(messageOf(options), "no OpenNI2 device 'SERIAL-2'; devices: rendered://flight");
  options = small();
  options.color_width = 640;
  EXPECT_EQ(messageOf(options), "rendered://flight: colour: no mode 640x240@15; modes: 320x240@15");
  options.device = "/nowhere/flight.oni";
  EXPECT_EQ(messageOf(options), "/nowhere/flight.oni: no such recording");
}

TEST(OpenNi2Camera, UnpluggedAndPluggedInAgain) {
  const std::string file = std::getenv("EDGE_MCL_DRIVER_PLUGGED");
  OpenNi2Camera::Frame frame;
  {
    OpenNi2Camera camera(small());
    firstOf(&camera, false);
    std::filesystem::remove(file);
    Event event = Event::kNothing;
    for (int i = 0; i < 100 && event != Event::kLost; ++i) event = camera.read(&frame, 50);
    EXPECT_EQ(event, Event::kLost);
    EXPECT_EQ(camera.read(&frame, 50), Event::kLost);
  }
  EXPECT_NE(messageOf(small()).find("no OpenNI2 device found"), std::string::npos);
  std::ofstream(file).put('x');
  for (int i = 0; i < 100 && OpenNi2Camera::devices().empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  OpenNi2Camera camera(small());
  firstOf(&camera, true);
}

TEST(OpenNi2Camera, PlaysARecordingMadeByTheRuntime) {
  const std::string file = testing::TempDir() + "flight" + std::to_string(getpid()) + ".oni";
  {
    const OpenNi2Camera starts_the_runtime(small());
    openni::Device device;
    ASSERT_EQ(device.open(openni::ANY_DEVICE), openni::STATUS_OK);
    openni::VideoStream color, depth;
    ASSERT_EQ(color.create(device, openni::SENSOR_COLOR), openni::STATUS_OK);
    ASSERT_EQ(depth.create(device, openni::SENSOR_DEPTH), openni::STATUS_OK);
    openni::Recorder recorder;
    ASSERT_EQ(recorder.create(file.c_str()), openni::STATUS_OK);
    ASSERT_EQ(recorder.attach(color), openni::STATUS_OK);
    ASSERT_EQ(recorder.attach(depth), openni::STATUS_OK);
    color.start();
    depth.start();
    ASSERT_EQ(recorder.start(), openni::STATUS_OK);
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));
    recorder.stop();
    recorder.destroy();
  }
  const std::vector<RecordedFrame> truth = flight();
  DepthCameraOptions options;
  options.device = file;
  OpenNi2Camera camera(options);
  int depths = 0, colors = 0;
  Event event = Event::kNothing;
  for (int i = 0; i < 1000 && event != Event::kEnd; ++i) {
    OpenNi2Camera::Frame frame;
    event = camera.read(&frame, 100);
    if (event != Event::kFrame) continue;
    ++(frame.is_depth ? depths : colors);
    if (!frame.is_depth) continue;
    // The recording has its own times. So the depth image is compared with all frames of the
    // flight.
    bool found = false;
    for (const RecordedFrame& t : truth) {
      cv::Mat expected;
      t.depth.convertTo(expected, CV_16U, 1000.0 / 5000);
      found = found || isSame(frame.pixels, expected);
    }
    EXPECT_TRUE(found);
  }
  EXPECT_EQ(event, Event::kEnd);
  EXPECT_GE(depths, 3);
  EXPECT_GE(colors, 3);
  std::filesystem::remove(file);
}

TEST(OpenNi2Camera, ABrokenRecordingIsAnError) {
  const std::string file = testing::TempDir() + "broken" + std::to_string(getpid()) + ".oni";
  std::ofstream(file) << "this is no recording";
  DepthCameraOptions options;
  options.device = file;
  EXPECT_NE(messageOf(options).find("cannot be opened"), std::string::npos);
  std::filesystem::remove(file);
}

TEST(DeviceClock, FindsTheOffsetThroughJitter) {
  // Frames arrive 5 ms after they were taken, plus an exponential delay with a mean of 10 ms. The
  // clock of the device is 20 ppm too slow.
  std::mt19937_64 random(7);
  std::exponential_distribution<double> delay(1 / 0.01);
  DeviceClock clock;
  double last = 0;
  for (int i = 0; i < 3000; ++i) {
    const double taken = 1000 + i / 30.0, device = (taken - 1000) * (1 - 20e-6) + 3;
    const double stamp = clock.toHost(device, taken + 0.005 + delay(random));
    EXPECT_GT(stamp, last - 1e-9);
    if (i > 100) {
      // The error is the smallest delay, plus the drift that the clock allows between frames
      // without further delay (about one in thirty), plus the real drift.
      EXPECT_NEAR(stamp, taken + 0.005, 0.004) << i;
    }
    last = stamp;
  }
  // The device starts again and counts from zero.
  EXPECT_NEAR(clock.toHost(0, 2000), 2000, 1e-9);
}

/// Plugs the device in before the runtime starts.
const bool kPlugged = [] {
  std::ofstream(std::getenv("EDGE_MCL_DRIVER_PLUGGED")).put('x');
  return true;
}();

}  // namespace
}  // namespace edge_mcl
