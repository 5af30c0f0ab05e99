// Videos and pictures.
#include "edge_mcl/viewer/view_recorder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "edge_mcl/core/error.h"
#include "viewer/view_scenes.h"

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

}  // namespace
}  // namespace edge_mcl
