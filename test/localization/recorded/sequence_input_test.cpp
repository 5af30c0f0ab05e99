#include "edge_mcl/localization/recorded/sequence_input.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

/// Makes a directory with the list of three images within one second. The files of an image are
/// made by the tests.
class SequenceInputTest : public test::WithFolder {
 protected:
  SequenceInputTest() {
    write("camera.yaml",
          "image_width: 40\nimage_height: 30\ncamera_matrix: {rows: 3, cols: 3, data: [30, 0, 20, "
          "0, 30, 15, 0, 0, 1]}\ndistortion_model: plumb_bob\n"
          "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n");
    write("rgb.txt", "10.0 a.png\n10.5 b.png\n11.0 c.png\n");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
  }
  /// An image of one grey value.
  void writeImage(const std::string& name, int grey = 90) const {
    cv::imwrite(path(name), cv::Mat(30, 40, CV_8UC1, cv::Scalar(grey)));
  }
  /// A mask of the left half.
  void writeMask(const std::string& name) const {
    cv::Mat mask(30, 40, CV_8UC1, cv::Scalar(0));
    mask.colRange(0, 20) = 255;
    cv::imwrite(path(name), mask);
  }
  void writeDepth(const std::string& name) const {
    cv::imwrite(path(name), cv::Mat(30, 40, CV_16UC1, cv::Scalar(4000)));
  }
  /// The first image with a mask and a depth image.
  void writeFirstMoment() const {
    writeImage("a.png");
    writeMask("mask.png");
    writeDepth("depth.png");
    write("mask.txt", "10.0 mask.png\n");
    write("depth.txt", "10.0 depth.png\n");
  }
  Sequence read() const { return readSequence(folder_.string()); }

  static constexpr SequenceParts kAll{true, true, true};
};

TEST_F(SequenceInputTest, ReadsTheFilesOfOneMoment) {
  writeFirstMoment();
  write("odometry.txt", "10.0 1 2 3 0 0 0 1\n10.02 1 2 3 0 0 0 1\n");
  write("sequence.yaml", "depth_scale: 2000\n");
  const Sequence sequence = read();
  std::string problem = "an older problem";
  const LiveInput input = readInput(sequence, sequence.frames[0], kAll, &problem);
  EXPECT_EQ(problem, "an older problem");  // it is set only when files are left out
  EXPECT_EQ(input.time, 10);
  EXPECT_EQ(input.time_text, "10.0");
  ASSERT_TRUE(input.odometry);
  EXPECT_EQ(input.odometry->translation(), Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(input.images.size(), 1u);
  const LiveInput::CameraImage& view = input.images[0];
  EXPECT_EQ(view.camera.width, 40);
  EXPECT_EQ(view.image.at<uint8_t>(7, 9), 90);
  EXPECT_EQ(cv::countNonZero(view.mask), 20 * 30);
  EXPECT_EQ(view.T_base_camera.matrix(), Pose::Identity().matrix());
  EXPECT_PRED2(test::contains, view.origin, "a.png");
  ASSERT_EQ(input.depths.size(), 1u);
  const DepthImage& depth = input.depths[0].image;
  EXPECT_EQ(depth.depth.at<uint16_t>(7, 9), 4000);
  EXPECT_EQ(depth.units_per_metre, 2000);
  ASSERT_TRUE(depth.mask);
  EXPECT_EQ(cv::norm(depth.mask->pixels, view.mask, cv::NORM_INF), 0);
  EXPECT_EQ(depth.mask->T_mask_depth.matrix(), Pose::Identity().matrix());
}

TEST_F(SequenceInputTest, ReadsOnlyTheWantedParts) {
  writeFirstMoment();
  const Sequence sequence = read();
  std::string problem;
  const auto with = [&](bool images, bool masks, bool depths) {
    return readInput(sequence, sequence.frames[0], {images, masks, depths}, &problem);
  };
  EXPECT_TRUE(with(false, true, true).images.empty());
  EXPECT_TRUE(with(false, true, true).depths.at(0).image.mask);
  EXPECT_TRUE(with(true, false, true).images.at(0).mask.empty());
  EXPECT_FALSE(with(true, false, true).depths.at(0).image.mask);
  EXPECT_TRUE(with(true, true, false).depths.empty());
  EXPECT_EQ(problem, "");
}

TEST_F(SequenceInputTest, AnImageThatCannotBeReadCostsItsMoment) {
  writeFirstMoment();
  write("a.png", "no image");
  const Sequence sequence = read();
  std::string problem;
  const LiveInput input = readInput(sequence, sequence.frames[0], kAll, &problem);
  EXPECT_TRUE(input.images.empty());
  EXPECT_TRUE(input.depths.empty());
  EXPECT_EQ(input.time, 10);
  EXPECT_PRED2(test::contains, problem, "a.png");
  EXPECT_EQ(problem.find('\n'), std::string::npos);
}

TEST_F(SequenceInputTest, AMaskThatCannotBeReadCostsItsMoment) {
  writeFirstMoment();
  write("mask.png", "no image");
  const Sequence sequence = read();
  std::string problem;
  const LiveInput input = readInput(sequence, sequence.frames[0], kAll, &problem);
  EXPECT_TRUE(input.images.empty());
  EXPECT_TRUE(input.depths.empty());
  EXPECT_PRED2(test::contains, problem, "mask.png");
  // Without masks the file is not needed.
  EXPECT_EQ(readInput(sequence, sequence.frames[0], {true, false, true}, &problem).images.size(),
            1u);
}

TEST_F(SequenceInputTest, ABadDepthImageDoesNotCostTheImage) {
  cv::imwrite(path("a.png"), cv::Mat(30, 40, CV_8UC1, cv::Scalar(90)));
  cv::imwrite(path("half.png"), cv::Mat(15, 20, CV_16UC1, cv::Scalar(5000)));
  write("depth.txt", "10.0 half.png\n");
  const Sequence sequence = read();
  std::string problem;
  const LiveInput input = readInput(sequence, sequence.frames[0], {true, true, true}, &problem);
  EXPECT_EQ(input.images.size(), 1u);
  EXPECT_TRUE(input.depths.empty());
  EXPECT_NE(problem.find("half.png"), std::string::npos);
}

TEST_F(SequenceInputTest, TheInitialGaussianHasTheGivenDeviations) {
  test::expectError<InputError>("initial_pose", [&] { initialGaussian(read(), 0.1, 0.1); });
  write("sequence.yaml", "initial_pose: [1, 2, 3, 0, 0, 0, 1]\n");
  const PoseGaussian initial = initialGaussian(read(), 0.2, 0.3);
  EXPECT_EQ(initial.mean.translation(), Eigen::Vector3d(1, 2, 3));
  const Matrix6 expected = (Twist() << 0.04, 0.04, 0.04, 0.09, 0.09, 0.09).finished().asDiagonal();
  EXPECT_TRUE(initial.covariance.isApprox(expected, 1e-12));
}

TEST_F(SequenceInputTest, GivesTheMomentsInTheirOrderWithTheirProblems) {
  writeImage("a.png", 10);
  writeImage("c.png", 30);  // b.png is missing
  write("groundtruth.txt", "10.0 4 5 6 0 0 0 1\n11.0 7 8 9 0 0 0 1\n");
  write("sequence.yaml", "initial_pose: [1, 2, 3, 0, 0, 0, 1]\ninitial_std: [0.25, 0.5]\n");
  SequenceInput input(read(), SequenceParts());
  EXPECT_EQ(input.imageCount(), 3u);
  EXPECT_EQ(input.damage(), "");
  ASSERT_TRUE(input.initialPose());
  EXPECT_EQ(input.initialPose()->mean.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_NEAR(input.initialPose()->covariance(2, 2), 0.0625, 1e-12);
  EXPECT_NEAR(input.initialPose()->covariance(5, 5), 0.25, 1e-12);
  ASSERT_EQ(input.truth().size(), 2u);
  EXPECT_EQ(input.truth()[1].time, 11);
  EXPECT_EQ(input.truth()[1].time_text, "11.0");
  EXPECT_EQ(input.truth()[1].pose.translation(), Eigen::Vector3d(7, 8, 9));

  LiveInput moment;
  std::string problem = "an older problem";
  ASSERT_TRUE(input.next(&moment, &problem));
  EXPECT_EQ(problem, "");
  EXPECT_EQ(moment.images.at(0).image.at<uint8_t>(0, 0), 10);
  ASSERT_TRUE(input.next(&moment, &problem));
  EXPECT_PRED2(test::contains, problem, "b.png");
  EXPECT_EQ(moment.time, 10.5);
  EXPECT_TRUE(moment.images.empty());
  ASSERT_TRUE(input.next(&moment, &problem));
  EXPECT_EQ(problem, "");
  EXPECT_EQ(moment.images.at(0).image.at<uint8_t>(0, 0), 30);
  EXPECT_FALSE(input.next(&moment, &problem));
}

TEST_F(SequenceInputTest, WithoutAnInitialPoseThereIsNone) {
  const SequenceInput input(read(), SequenceParts());
  EXPECT_FALSE(input.initialPose());
  EXPECT_TRUE(input.truth().empty());
}

}  // namespace
}  // namespace edge_mcl
