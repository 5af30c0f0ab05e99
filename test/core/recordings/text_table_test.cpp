#include "edge_mcl/core/recordings/text_table.h"

#include <gtest/gtest.h>

#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "support/error_text.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

using test::expectError;

class TextTable : public test::WithFolder {
 protected:
  /// @return path of a file with this text
  std::string fileWith(const std::string& text) const {
    std::ofstream(path("table.txt"), std::ios::binary) << text;
    return path("table.txt");
  }
  Trajectory trajectoryOf(const std::string& text) const { return readTrajectory(fileWith(text)); }
};

/// A quarter turn about z has the quaternion (0, 0, sin 45, cos 45).
TEST_F(TextTable, ATrajectoryIsReadLineByLine) {
  const Trajectory poses = trajectoryOf(
      "# timestamp tx ty tz qx qy qz qw\n"
      "\n"
      "   \t\n"
      "1305031102.1753 1 -2.5 3e-1 0 0 0.70710678 0.70710678  # a comment behind\n"
      "1305031102.2\t0 0 0  0 0 0 1");  // the last line has no line end
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].time, 1305031102.1753);
  EXPECT_EQ(poses[0].time_text, "1305031102.1753");
  EXPECT_EQ(poses[0].pose.translation(), Eigen::Vector3d(1, -2.5, 0.3));
  // The map's x axis becomes its y axis. The file has eight decimals.
  EXPECT_LT((poses[0].pose.linear().col(0) - Eigen::Vector3d::UnitY()).norm(), 1e-7);
  EXPECT_TRUE(isValid(poses[0].pose));
  EXPECT_LT((poses[1].pose.matrix() - Pose::Identity().matrix()).norm(), 1e-12);
}

TEST_F(TextTable, LineEndsOfWindowsAreRead) {
  const Trajectory poses = trajectoryOf("1 0 0 0 0 0 0 1\r\n\r\n2 0 0 0 0 0 0 1\r\n");
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1].time_text, "2");
}

/// Only too few numbers are a fault.
TEST_F(TextTable, MoreColumnsAreIgnored) {
  EXPECT_EQ(trajectoryOf("1 0 0 0 0 0 0 1 0.5 0.5\n").size(), 1u);
}

TEST_F(TextTable, AnEmptyFileIsAnEmptyTrajectory) {
  EXPECT_TRUE(trajectoryOf("").empty());
  EXPECT_TRUE(trajectoryOf("# nothing\n").empty());
}

/// The quaternion may be rounded in the file. It is scaled to unit length.
TEST_F(TextTable, ARoundedQuaternionIsNormalised) {
  const Trajectory poses = trajectoryOf("1 0 0 0 0 0.502 0 0.87\n");
  EXPECT_TRUE(isValid(poses.front().pose));
}

TEST_F(TextTable, AFaultIsReportedWithFileAndLine) {
  const std::string good = "# a comment\n1 0 0 0 0 0 0 1\n";
  const auto fault = [&](const std::string& line, const std::string& text) {
    const std::string file = fileWith(good + line + "\n3 0 0 0 0 0 0 1\n");
    expectError<InputError>(file + ":3: ", [&] { readTrajectory(file); });
    expectError<InputError>(text, [&] { readTrajectory(file); });
  };
  fault("2 0 0 0 0 0 0", "'timestamp tx ty tz qx qy qz qw' expected");
  fault("2 0 0 0 0 0 0 # 1", "expected");
  fault("2 0 x 0 0 0 0 1", "'x' is not a finite number");
  fault("2 0 1.5m 0 0 0 0 1", "'1.5m' is not a finite number");
  fault("2 0 nan 0 0 0 0 1", "'nan' is not a finite number");
  fault("2 0 inf 0 0 0 0 1", "'inf' is not a finite number");
  fault("2 0 1e999 0 0 0 0 1", "'1e999' is not a finite number");
  fault("2 0 0 0 0 0 0 0.9", "unit length");
  fault("2 0 0 0 0 0 0 0", "unit length");
  fault("1 0 0 0 0 0 0 1", "time does not increase");
  fault("0.5 0 0 0 0 0 0 1", "time does not increase");
}

TEST_F(TextTable, AMissingFileIsAnError) {
  expectError<InputError>("none.txt: cannot be read", [&] { readTrajectory(path("none.txt")); });
  expectError<InputError>("none.txt: cannot be read", [&] { readFileList(path("none.txt")); });
}

/// A pose that is written and read again is the same pose. The file has nine decimals, so a number
/// has an error of half a unit of the ninth.
TEST_F(TextTable, AWrittenPoseIsReadAgain) {
  RandomSource random(4);
  std::vector<Pose> poses;
  std::string text;
  for (int i = 0; i < 100; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() = expSo3(M_PI * random.uniform() * random.direction());
    pose.translation() = 20 * random.direction();
    poses.push_back(pose);
    text += formatPose(std::to_string(i) + ".500", pose) + "\n";
  }
  const Trajectory read = trajectoryOf(text);
  ASSERT_EQ(read.size(), poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(read[i].time_text, std::to_string(i) + ".500");
    EXPECT_LT((read[i].pose.translation() - poses[i].translation()).lpNorm<Eigen::Infinity>(),
              0.51e-9);
    // Four numbers of the quaternion have this error, and a matrix is of second degree in them.
    EXPECT_LT((read[i].pose.linear() - poses[i].linear()).lpNorm<Eigen::Infinity>(), 1e-8);
  }
}

TEST_F(TextTable, APoseIsWrittenInTheOrderOfTheBenchmark) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(1, -2.5, 0.125);
  EXPECT_EQ(formatPose("12.50", pose),
            "12.50 1.000000000 -2.500000000 0.125000000 0.000000000 0.000000000 0.000000000 "
            "1.000000000");
  EXPECT_EQ(formatPose("1e3", pose).substr(0, 4), "1e3 ") << "the digits of the time are kept";
}

/// EuRoC counts nanoseconds and writes w first. What is written is read again.
TEST_F(TextTable, APoseIsWrittenAsEurocDoes) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(1, -2.5, 0.125);
  const std::string rest =
      ",1.000000000,-2.500000000,0.125000000,1.000000000,0.000000000,"
      "0.000000000,0.000000000";
  EXPECT_EQ(formatEurocPose("1403636579.7585", pose), "1403636579758500000" + rest);
  EXPECT_EQ(formatEurocPose("12", pose), "12000000000" + rest);
  EXPECT_EQ(formatEurocPose("0.5", pose), "500000000" + rest);
  EXPECT_EQ(formatEurocPose("0.000", pose), "0" + rest);
  const Trajectory read = trajectoryOf(std::string(kEurocColumns) + "\n" +
                                       formatEurocPose("1403636579.7585", pose) + "\n");
  ASSERT_EQ(read.size(), 1u);
  EXPECT_NEAR(read[0].time, 1403636579.7585, 1e-6);
  EXPECT_LT((read[0].pose.matrix() - pose.matrix()).norm(), 1e-9);
}

/// Times of a list may be in any order.
TEST_F(TextTable, AFileListIsReadLineByLine) {
  const std::vector<StampedFile> files =
      readFileList(fileWith("# timestamp filename\n2.50 rgb/b.png\n1.0\trgb/a.png\n"));
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].time, 2.5);
  EXPECT_EQ(files[0].time_text, "2.50");
  EXPECT_EQ(files[0].file, "rgb/b.png");
  EXPECT_EQ(files[1].time, 1.0);
  EXPECT_TRUE(readFileList(fileWith("")).empty());
}

TEST_F(TextTable, AMalformedLineOfAListIsAnError) {
  for (const char* line : {"2.5", "2.5 a b.png", "x a.png", "nan a.png"}) {
    const std::string file = fileWith(std::string("1 a.png\n") + line + "\n");
    expectError<InputError>(file + ":2: ", [&] { readFileList(file); });
  }
}

/// A folder can be opened as a stream but not read.
TEST_F(TextTable, AFolderIsAnError) {
  EXPECT_THROW(readTrajectory(folder_.string()), InputError);
  EXPECT_THROW(readFileList(folder_.string()), InputError);
}

}  // namespace
}  // namespace edge_mcl
