// Tests videos and pictures that the viewer writes.
#include "edge_mcl/viewer/output/view_recorder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/viewer/output/video_file.h"
#include "support/view_scenes.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

class Recorder : public testing::Test {
 protected:
  Recorder() : folder_(fs::temp_directory_path() / ("view_" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
    params_.width = 640;
    params_.height = 400;
  }
  ~Recorder() override { fs::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  fs::path folder_;
  test::SimulatedMoment scene_;
  ViewParameters params_;
};

TEST_F(Recorder, WritesAVideoAndPicturesWhenTheyAreDue) {
  RecorderOptions options;
  options.video = file("flight.mp4");
  options.video_rate = 10;
  options.pictures = file("shot");
  options.at = {0.25, 0.45, 99};
  ViewRecorder recorder(scene_.map.get(), params_, options);
  for (int i = 0; i < 8; ++i) {
    ViewMoment m = scene_.moment;
    m.elapsed = 0.1 * i;
    m.time += m.elapsed;
    recorder.show(m);
  }
  EXPECT_TRUE(fs::exists(file("shot-2.png")));
  EXPECT_FALSE(fs::exists(file("shot-3.png"))) << "not due";
  recorder.close();
  EXPECT_EQ(recorder.written().size(), 4u);
  for (const char* name : {"shot-1.png", "shot-2.png", "shot-3.png"})
    EXPECT_EQ(cv::imread(file(name)).size(), cv::Size(640, 400)) << name;
  cv::VideoCapture video(file("flight.mp4"));
  ASSERT_TRUE(video.isOpened());
  cv::Mat frame;
  int frames = 0;
  while (video.read(frame)) {
    ++frames;
    ASSERT_EQ(frame.size(), cv::Size(640, 400));
  }
  EXPECT_EQ(frames, 8);
  EXPECT_NE(recorder.summary().find("8 moments: tracking 8"), std::string::npos)
      << recorder.summary();
  EXPECT_NE(recorder.summary().find("median 0.0 cm"), std::string::npos) << recorder.summary();
}

TEST_F(Recorder, SaysWhatCannotBeWritten) {
  const auto make = [&](RecorderOptions options) {
    ViewRecorder recorder(scene_.map.get(), params_, std::move(options));
    recorder.show(scene_.moment);
    recorder.close();
  };
  RecorderOptions o;
  o.video = file("flight.gif");
  EXPECT_THROW(make(o), ParameterError);
  o.video = "/nonexistent/flight.mp4";
  EXPECT_THROW(make(o), InputError);
  o = {};
  o.pictures = "/nonexistent/shot";
  EXPECT_THROW(make(o), InputError);
  o.at = {2, 1};
  EXPECT_THROW(make(o), ParameterError);
  o = {};
  o.video = file("ok.mp4");
  o.video_rate = 0;
  EXPECT_THROW(make(o), ParameterError);
}

/// A limit on the size of files acts as a full disk.
TEST_F(Recorder, AFullDiskIsSaid) {
  for (const char* name : {"full.mp4", "full.avi"}) {
    RecorderOptions options;
    options.video = file(name);
    ViewRecorder recorder(scene_.map.get(), params_, options);
    recorder.show(scene_.moment);
    const auto previous = std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{2000, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    std::string message;
    try {
      for (int i = 0; i < 12; ++i) recorder.show(scene_.moment);
      recorder.close();
    } catch (const InputError& e) {
      message = e.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, previous);
    EXPECT_NE(message.find(name), std::string::npos) << name << ": " << message;
    EXPECT_NE(message.find("cannot be written"), std::string::npos) << message;
  }
}

/// A video of 25 pictures per second must last as long as the 8 s that were shown.
TEST(VideoPace, AVideoIsAsLongAsItTook) {
  for (const double shown : {3.0, 25.0, 60.0}) {  // pictures per second
    VideoPace pace(25, 100);
    EXPECT_EQ(pace.copiesAt(100), 1);
    int written = 1;
    for (int i = 1; i <= 8 * shown; ++i) written += pace.copiesAt(100 + i / shown);
    EXPECT_NEAR(written, 8 * 25, 1) << shown;
  }
  VideoPace pace(25, 0);
  EXPECT_EQ(pace.copiesAt(1000), 250) << "after a long pause";
  EXPECT_EQ(pace.copiesAt(1000.01), 0) << "which is done with";
  EXPECT_EQ(pace.copiesAt(1000.05), 1);
}

}  // namespace
}  // namespace edge_mcl
