// Tests that folders of other programs are read. The truth is what their documents say.
#include "edge_mcl/core/recordings/foreign_folders.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

class ForeignFolder : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }
  void write(const std::string& name, const std::string& text) {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text;
  }
  void picture(const std::string& name) {
    fs::create_directories((root_ / name).parent_path());
    cv::imwrite((root_ / name).string(), cv::Mat::zeros(30, 40, CV_8U));
  }
  void calibration(const std::string& name) {
    write(
        name,
        "image_width: 40\nimage_height: 30\ncamera_matrix: {data: [30, 0, 20, 0, 30, 15, 0, 0, 1]}"
        "\ndistortion_model: plumb_bob\ndistortion_coefficients: {data: [0, 0, 0, 0, 0]}\n");
  }
  Sequence read(const std::string& camera = "") const {
    return readSequence(root_.string(), camera.empty() ? "" : (root_ / camera).string());
  }
  std::string errorOf() const {
    return test::errorText<InputError>([&] { read(); });
  }
  fs::path root_;
};

/// The camera looks along the x axis of the body and stands 0.1 m before its centre. At the first
/// image the body is turned by 90 degrees about the vertical. w comes first in the quaternions.
TEST_F(ForeignFolder, Euroc) {
  write("mav0/cam0/data.csv",
        "#timestamp [ns],filename\n1403636579763555584,1403636579763555584.png\n"
        "1403636579813555456,1403636579813555456.png\n");
  write("mav0/cam0/sensor.yaml",
        "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0, 0, 1, 0.1, -1, 0, 0, 0, 0, "
        "-1, 0, 0, 0, 0, 0, 1]\nresolution: [40, 30]\ncamera_model: pinhole\n"
        "intrinsics: [30, 30, 20, 15]\ndistortion_model: radial-tangential\n"
        "distortion_coefficients: [0, 0, 0, 0]\n");
  write("mav0/state_groundtruth_estimate0/data.csv",
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
        "q_RS_z [], v_RS_R_x [m s^-1]\n"
        "1403636579763555584,1,2,3,0.70710678,0,0,0.70710678,0.5\n"
        "1403636579813555456,1,2,3,1,0,0,0,0.5\n");
  const Sequence sequence = read();
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_EQ(sequence.camera.width, 40);
  EXPECT_EQ(sequence.frames[0].time_text, "1403636579.763555584");
  EXPECT_EQ(sequence.frames[0].image_file,
            (root_ / "mav0/cam0/data/1403636579763555584.png").string());
  ASSERT_TRUE(sequence.frames[0].ground_truth && sequence.frames[1].ground_truth);
  EXPECT_TRUE(
      sequence.frames[0].ground_truth->translation().isApprox(Eigen::Vector3d(1, 2.1, 3), 1e-6));
  EXPECT_TRUE(
      sequence.frames[0].ground_truth->linear().col(2).isApprox(Eigen::Vector3d(0, 1, 0), 1e-6));
  EXPECT_TRUE(
      sequence.frames[1].ground_truth->linear().col(2).isApprox(Eigen::Vector3d(1, 0, 0), 1e-6));
}

TEST_F(ForeignFolder, Kitti) {
  for (const char* name : {"000000.png", "000001.png"}) picture(std::string("image_0/") + name);
  write("times.txt", "0.000000e+00\n1.036224e-01\n");
  write("calib.txt", "P0: 30 0 20 0 0 31 15 0 0 0 1 0\nP1: 30 0 20 -386 0 31 15 0 0 0 1 0\n");
  const Sequence sequence = read();
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_NEAR(sequence.frames[1].time, 0.1036224, 1e-9);
  EXPECT_EQ(sequence.camera.fy, 31);
  EXPECT_EQ(sequence.camera.distortion, DistortionModel::kNone);
}

TEST_F(ForeignFolder, PhotographsInTheOrderOfTheirNumbers) {
  for (const char* name : {"shot_10.png", "shot_9.png", "shot_009b.png", "shot_2.PNG", "notes.txt"})
    picture(name == std::string("notes.txt") ? "x.png" : name);
  fs::remove(root_ / "x.png");
  write("notes.txt", "no image");
  EXPECT_NE(errorOf().find("--camera"), std::string::npos) << errorOf();
  calibration("calibration.yaml");
  const Sequence sequence = read("calibration.yaml");
  ASSERT_EQ(sequence.frames.size(), 4u);
  const char* const order[] = {"shot_2.PNG", "shot_9.png", "shot_009b.png", "shot_10.png"};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(fs::path(sequence.frames[i].image_file).filename(), order[i]);
    EXPECT_NEAR(sequence.frames[i].time, 0.1 * static_cast<double>(i), 1e-9);
  }
  ASSERT_EQ(sequence.warnings.size(), 1u);
  EXPECT_NE(sequence.warnings[0].find("ten images per second"), std::string::npos);
}

TEST_F(ForeignFolder, PhotographsWhoseNamesAreTimes) {
  for (const char* name : {"1700000001.500000.png", "1700000000.250000.png"}) picture(name);
  calibration("camera.yaml");
  const Sequence sequence = read();
  ASSERT_EQ(sequence.frames.size(), 2u);
  EXPECT_NEAR(sequence.frames[1].time - sequence.frames[0].time, 1.25, 1e-6);
  EXPECT_TRUE(sequence.warnings.empty());
}

/// Counters of ten digits (KITTI raw) and dates in one number are no times.
TEST_F(ForeignFolder, CountersAndDatesAreNoTimes) {
  calibration("camera.yaml");
  for (const char* const name : {"0000000001.png", "20240101120000.png"}) {
    picture(name);
    EXPECT_EQ(read().warnings.size(), 1u) << name;
    EXPECT_EQ(read().frames[0].time, 0) << name;
    fs::remove(root_ / name);
  }
}

TEST_F(ForeignFolder, InKittiAMissingImageMovesNoTime) {
  for (const char* name : {"000000.png", "000002.png"}) picture(std::string("image_0/") + name);
  write("times.txt", "0.0\n0.1\n0.2\n");
  write("calib.txt", "P0: 30 0 20 0 0 31 15 0 0 0 1 0\n");
  EXPECT_NEAR(read().frames[1].time, 0.2, 1e-9);
  write("times.txt", "0.0\n0.1\nnan\n");
  EXPECT_NE(errorOf().find("times.txt:3"), std::string::npos) << errorOf();
}

/// The marker of the motion capture is 0.3 m above the body.
TEST_F(ForeignFolder, TheTruthOfAMarkerIsMovedToTheCamera) {
  const std::string mounting = "T_BS:\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, ";
  write("mav0/cam0/data.csv", "#timestamp [ns],filename\n1403636579763555584,a.png\n");
  const std::string camera =
      "resolution: [40, 30]\ncamera_model: pinhole\nintrinsics: [30, 30, 20, 15]\n"
      "distortion_model: none\ndistortion_coefficients: []\n";
  write("mav0/cam0/sensor.yaml", mounting + "0.1, 0, 0, 0, 1]\n" + camera);
  write("mav0/vicon0/sensor.yaml", mounting + "0.3, 0, 0, 0, 1]\n");
  write(
      "mav0/vicon0/data.csv",
      "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
      "q_RS_z []\n1403636579763555584,1,2,3,1,0,0,0\n");
  EXPECT_TRUE(read().frames[0].ground_truth->translation().isApprox(Eigen::Vector3d(1, 2, 2.8)));
  write("mav0/cam0/sensor.yaml",
        "T_BS:\n  data: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]\n" + camera);
  EXPECT_NE(errorOf().find("T_BS"), std::string::npos) << errorOf();
}

TEST_F(ForeignFolder, AFolderOfNoKindSaysWhatIsKnown) {
  EXPECT_NE(errorOf().find("KITTI"), std::string::npos) << errorOf();
}

TEST_F(ForeignFolder, BagsOfRos2AreNamed) {
  write("metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n");
  EXPECT_NE(errorOf().find("rosbags-convert"), std::string::npos) << errorOf();
}

TEST_F(ForeignFolder, AnOwnFolderStaysWhatItIs) {
  calibration("camera.yaml");
  picture("preview.png");
  write("rgb.txt", "1 a.png\n");
  EXPECT_EQ(read().frames[0].image_file, (root_ / "a.png").string());
}

/// A table with commas whose first line does not name its columns may have w first or last.
TEST_F(ForeignFolder, ATableWithoutNamesIsRefused) {
  write("truth.csv", "1,0,0,0,1,0,0,0\n");
  const std::string file = (root_ / "truth.csv").string();
  EXPECT_NE(test::errorText<InputError>([&] { readTrajectory(file); }).find("names the columns"),
            std::string::npos);
  write("truth.csv", "time,x,y,z,qx,qy,qz,qw\n1,0,0,0,0,0,0.6,0.8\n");
  EXPECT_NEAR(logSo3(readTrajectory(file)[0].pose.linear()).z(), 2 * std::asin(0.6), 1e-9);
  for (const char* const head :
       {"time,x,y,z,qw,qx,qy,qz", "# made by a tool\n#timestamp tx ty tz q_w q_x q_y q_z",
        "# now\n# time x y z w x y z",
        "#t,p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x []"}) {
    write("truth.csv", std::string(head) + "\n1,0,0,0,0.8,0,0,0.6\n");
    EXPECT_NEAR(logSo3(readTrajectory(file)[0].pose.linear()).z(), 2 * std::asin(0.6), 1e-9)
        << head;
  }
  write("truth.csv", "# made by a tool\n# timestamp tx ty tz qx qy qz qw\n1 0 0 0 0 0 0.6 0.8\n");
  EXPECT_NEAR(logSo3(readTrajectory(file)[0].pose.linear()).z(), 2 * std::asin(0.6), 1e-9);
}

}  // namespace
}  // namespace edge_mcl
