#include "edge_mcl/core/recordings/sequence.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

/// Makes a directory with the list of three images within one second.
class SequenceTest : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(root_);
    fs::create_directories(root_);
    write("camera.yaml",
          "image_width: 40\nimage_height: 30\ncamera_matrix: {rows: 3, cols: 3, data: [30, 0, 20, "
          "0, 30, 15, 0, 0, 1]}\ndistortion_model: plumb_bob\n"
          "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n");
    write("rgb.txt", "10.0 a.png\n10.5 b.png\n11.0 c.png\n");
    camera_ = CameraModel::fromYamlFile((root_ / "camera.yaml").string());
  }
  void TearDown() override { fs::remove_all(root_); }
  void write(const std::string& name, const std::string& text) {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text;
  }
  Sequence read() const { return readSequence(root_.string()); }

  fs::path root_;
  CameraModel camera_;
};

TEST_F(SequenceTest, IsCalledAsItsDirectory) {
  EXPECT_EQ(read().name, root_.filename().string());
  EXPECT_EQ(readSequence(root_.string() + "/").name, root_.filename().string());
}

TEST_F(SequenceTest, NeedsNoInitialPoseUntilItIsAskedFor) {
  const Sequence sequence = read();
  EXPECT_FALSE(sequence.initial_pose);
  EXPECT_THROW(startOf(sequence), InputError);
  write("sequence.yaml", "initial_pose: [1, 2, 3, 0, 0, 0, 1]\n");
  EXPECT_EQ(startOf(read()).translation(), Eigen::Vector3d(1, 2, 3));
}

/// The robot moves along a line at 2 m/s and turns about this line at 1 rad/s. So its true pose is
/// known at every time. The first image is 0.03 s older than the first reading, and the odometry is
/// extrapolated to it. The last image is 0.07 s newer than the last reading, which is too far.
TEST_F(SequenceTest, OdometryOfOtherTimesIsInterpolated) {
  std::string lines;
  for (int k = 1; k <= 10; ++k) {  // the first reading is at 10.03 s
    const double t = 9.93 + 0.1 * k, angle = t - 9.93;
    lines += std::to_string(t) + " " + std::to_string(2 * angle) + " 0 0 " +
             std::to_string(std::sin(angle / 2)) + " 0 0 " + std::to_string(std::cos(angle / 2)) +
             "\n";
  }
  write("odometry.txt", lines);
  const Sequence sequence = read();
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(sequence.frames[i].odometry);
    const double since = 0.07 + 0.5 * static_cast<double>(i);
    // The file has six decimals.
    EXPECT_NEAR(sequence.frames[i].odometry->translation().x(), 2 * since, 1e-5);
    EXPECT_NEAR(logSo3(sequence.frames[i].odometry->linear()).x(), since, 1e-5);
  }
  EXPECT_FALSE(sequence.frames[2].odometry);  // odometry ends at 10.93 s
  ASSERT_EQ(sequence.warnings.size(), 1u);
  EXPECT_NE(sequence.warnings[0].find("none for 1 of 3"), std::string::npos);
}

TEST_F(SequenceTest, ListsOfOtherTimesAreWarnedOf) {
  write("mask.txt", "20.0 a.png\n");
  write("depth.txt", "10.2 a.png\n");
  write("odometry.txt", "20.0 0 0 0 0 0 0 1\n");
  const Sequence sequence = read();
  ASSERT_EQ(sequence.warnings.size(), 3u);
  for (size_t i = 0; i < 3; ++i)
    EXPECT_NE(sequence.warnings[i].find(std::vector<std::string>{"odometry", "mask", "depth"}[i]),
              std::string::npos);
}

TEST_F(SequenceTest, MasksOfAPartOfTheImagesAreWarnedOf) {
  write("mask.txt", "10.0 a.png\n");
  Sequence sequence = read();
  ASSERT_EQ(sequence.warnings.size(), 1u);
  EXPECT_NE(sequence.warnings[0].find("mask.txt: none for 2 of 3"), std::string::npos);
  sequence.warnings.clear();
  write("other/mask.txt", "10.0 a.png\n10.5 b.png\n");
  useMasks((root_ / "other").string(), &sequence);
  ASSERT_EQ(sequence.warnings.size(), 1u);
  EXPECT_NE(sequence.warnings[0].find("other/mask.txt: none for 1 of 3"), std::string::npos);
  sequence.warnings.clear();
  write("other/mask.txt", "10.0 a.png\n10.5 b.png\n11.0 c.png\n");
  useMasks((root_ / "other").string(), &sequence);
  EXPECT_TRUE(sequence.warnings.empty());
}

TEST_F(SequenceTest, StampsInSmallerUnitsBecomeSeconds) {
  const std::string seconds = "1403715273.262142976";
  for (const auto& [first, second] : {std::pair{"1403715273262142976", "1403715273312143104"},
                                      std::pair{"1403715273262143", "1403715273312143"},
                                      std::pair{"1403715273262", "1403715273312"}}) {
    write("rgb.txt", std::string(first) + " a.png\n" + second + " b.png\n");
    const Sequence sequence = read();
    ASSERT_EQ(sequence.frames.size(), 2u);
    EXPECT_NEAR(sequence.frames[0].time, 1403715273.262, 1e-3);
    EXPECT_NEAR(sequence.frames[1].time - sequence.frames[0].time, 0.05, 1e-3);
    EXPECT_EQ(sequence.frames[0].time_text.rfind("1403715273.262", 0), 0u);
  }
  write("rgb.txt", "14037152732621429760000000 a.png\n");
  EXPECT_THROW(read(), InputError);
}

TEST_F(SequenceTest, AnyColourThatIsNotZeroIsMasked) {
  const std::string file = (root_ / "mask.png").string();
  const cv::Point there(7, 5);
  const auto check = [&](const cv::Mat& mask, const char* what) {
    cv::imwrite(file, mask);
    const cv::Mat read = readMask(file, camera_);
    ASSERT_EQ(read.type(), CV_8UC1) << what;
    EXPECT_EQ(read.at<uint8_t>(there), 255) << what;
    EXPECT_EQ(cv::countNonZero(read), 1) << what;
  };
  cv::Mat byte = cv::Mat::zeros(30, 40, CV_8UC1);
  byte.at<uint8_t>(there) = 1;
  check(byte, "8 bits");
  cv::Mat word = cv::Mat::zeros(30, 40, CV_16UC1);
  word.at<uint16_t>(there) = 3;
  check(word, "16 bits");
  cv::Mat blue = cv::Mat::zeros(30, 40, CV_8UC3);
  blue.at<cv::Vec3b>(there) = {3, 0, 0};
  check(blue, "dark blue");
  cv::Mat opaque(30, 40, CV_8UC4, cv::Scalar(0, 0, 0, 255));
  opaque.at<cv::Vec4b>(there) = {0, 0, 9, 255};
  check(opaque, "with alpha");
}

}  // namespace
}  // namespace edge_mcl
