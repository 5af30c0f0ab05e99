// Tests videos as recordings. The test writes them.
#include "edge_mcl/localization/recorded/video_input.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/videoio.hpp>

#include "edge_mcl/core/base/error.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

std::string writeVideo(const cv::Size& size, int count, double rate) {
  std::string file = testing::TempDir() + "video_input_test.avi";
  cv::VideoWriter writer(file, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                         rate, size);
  EXPECT_TRUE(writer.isOpened());
  for (int i = 0; i < count; ++i) writer.write(cv::Mat(size, CV_8UC3, cv::Scalar::all(20 * i)));
  return file;
}

TEST(VideoInput, GivesTheImagesAtTheirTimes) {
  const std::string file = writeVideo({320, 240}, 5, 20);
  VideoInput video(file, test::pinhole(320, 240, 220));
  EXPECT_EQ(video.imageCount(), 5u);
  LiveInput input;
  std::string problem;
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(video.next(&input, &problem)) << i;
    EXPECT_EQ(problem, "");
    EXPECT_NEAR(input.time, i / 20.0, 1e-3);
    ASSERT_EQ(input.images.size(), 1u);
    // JPEG changes an even image by little.
    EXPECT_NEAR(cv::mean(input.images[0].image)[1], 20 * i, 3);
  }
  EXPECT_FALSE(video.next(&input, &problem));
}

TEST(VideoInput, AnotherSizeThanThatOfTheCalibrationIsTold) {
  VideoInput video(writeVideo({160, 120}, 2, 20), test::pinhole(320, 240, 220));
  LiveInput input;
  std::string problem;
  ASSERT_TRUE(video.next(&input, &problem));
  EXPECT_TRUE(input.images.empty());
  EXPECT_NE(problem.find("160x120"), std::string::npos) << problem;
}

TEST(VideoInput, ACutVideoIsTold) {
  const std::string file = writeVideo({320, 240}, 30, 20);
  VideoInput whole(file, test::pinhole(320, 240, 220));
  LiveInput input;
  std::string problem;
  while (whole.next(&input, &problem)) continue;
  EXPECT_EQ(whole.damage(), "");
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  VideoInput cut(file, test::pinhole(320, 240, 220));
  size_t count = 0;
  while (cut.next(&input, &problem)) ++count;
  // Decoders that count the images themselves see no damage.
  EXPECT_EQ(cut.imageCount() > count + 1, cut.damage().find("cut off") != std::string::npos);
}

TEST(VideoInput, WhatIsNoVideoIsRefused) {
  const std::string file = testing::TempDir() + "no_video.mp4";
  std::ofstream(file) << "no video";
  EXPECT_THROW(VideoInput(file, test::pinhole(320, 240, 220)), InputError);
  EXPECT_THROW(VideoInput("/nowhere.mp4", test::pinhole(320, 240, 220)), InputError);
}

}  // namespace
}  // namespace edge_mcl
