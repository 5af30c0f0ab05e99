#include "edge_mcl/core/recordings/recording.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

using test::expectError;

class Recording : public test::WithFolder {
 protected:
  Recording() {
    sequence_.directory = folder_.string();
    sequence_.camera = test::pinhole(40, 30, 30);
    sequence_.depth_scale = 1000;
    sequence_.initial_std_position = 0.3;
    sequence_.initial_std_angle = 0.2;
    frame_.time = 12.5;
    frame_.image_file = path("image.png");
    cv::imwrite(frame_.image_file, cv::Mat(30, 40, CV_8UC3, cv::Scalar(10, 20, 30)));
  }

  Sequence sequence_;
  SequenceFrame frame_;
};

TEST_F(Recording, AFrameHasTheImageAndThePosesOfItsMoment) {
  frame_.ground_truth = test::lookAlong({1, 2, 3}, {1, 0, 0});
  frame_.odometry = test::lookAlong({4, 5, 6}, {0, 1, 0});
  const RecordedFrame loaded = loadFrame(sequence_, frame_);
  EXPECT_EQ(loaded.time, 12.5);
  ASSERT_EQ(loaded.color.size(), cv::Size(40, 30));
  EXPECT_EQ(loaded.color.at<cv::Vec3b>(7, 8), cv::Vec3b(10, 20, 30));
  ASSERT_TRUE(loaded.truth && loaded.odometry);
  EXPECT_EQ(loaded.truth->matrix(), frame_.ground_truth->matrix());
  EXPECT_EQ(loaded.odometry->matrix(), frame_.odometry->matrix());
}

/// Parts that do not exist are empty. The depth image is not loaded, even when there is one.
TEST_F(Recording, APartThatDoesNotExistIsEmpty) {
  frame_.depth_file = path("depth.png");
  cv::imwrite(frame_.depth_file, cv::Mat(30, 40, CV_16U, cv::Scalar(1000)));
  const RecordedFrame loaded = loadFrame(sequence_, frame_);
  EXPECT_TRUE(loaded.mask.empty());
  EXPECT_TRUE(loaded.depth.empty());
  EXPECT_FALSE(loaded.truth);
  EXPECT_FALSE(loaded.odometry);
}

TEST_F(Recording, AMaskIsNotZeroWhereItsFileIsNotZero) {
  cv::Mat mask(30, 40, CV_8U, cv::Scalar(0));
  mask.at<uint8_t>(5, 6) = 1;
  frame_.mask_file = path("mask.png");
  cv::imwrite(frame_.mask_file, mask);
  const RecordedFrame loaded = loadFrame(sequence_, frame_);
  ASSERT_EQ(loaded.mask.type(), CV_8U);
  EXPECT_EQ(cv::countNonZero(loaded.mask), 1);
  EXPECT_NE(loaded.mask.at<uint8_t>(5, 6), 0);
}

TEST_F(Recording, AFileThatCannotBeReadIsAnErrorWithItsName) {
  frame_.mask_file = path("missing_mask.png");
  expectError<InputError>("missing_mask.png", [&] { loadFrame(sequence_, frame_); });
  frame_.mask_file.clear();
  frame_.image_file = path("missing_image.png");
  expectError<InputError>("missing_image.png", [&] { loadFrame(sequence_, frame_); });
  frame_.image_file = path("small.png");
  cv::imwrite(frame_.image_file, cv::Mat(15, 20, CV_8U, cv::Scalar(0)));
  expectError<InputError>("20x15", [&] { loadFrame(sequence_, frame_); });
}

TEST_F(Recording, ItsSetupIsThatOfTheSequence) {
  sequence_.initial_pose = test::lookAlong({1, 2, 3}, {1, 1, 0});
  const Pose T_base_camera = test::lookAlong({0.1, 0, 0.2}, {1, 0, 0});
  const RecordingSetup setup = setupOf(sequence_, T_base_camera);
  EXPECT_EQ(setup.camera.width, 40);
  EXPECT_EQ(setup.camera.fx, 30);
  EXPECT_EQ(setup.T_base_camera.matrix(), T_base_camera.matrix());
  EXPECT_EQ(setup.depth_scale, 1000);
  EXPECT_EQ(setup.initial_pose.matrix(), sequence_.initial_pose->matrix());
  EXPECT_EQ(setup.initial_std_position, 0.3);
  EXPECT_EQ(setup.initial_std_angle, 0.2);
}

TEST_F(Recording, WithoutAnInitialPoseThereIsNoSetup) {
  expectError<InputError>("initial_pose is missing", [&] { setupOf(sequence_, Pose::Identity()); });
}

/// A recorder for a format without a place for depth images of their own time.
class PlainRecorder : public Recorder {
 public:
  void write(const RecordedFrame&) override { ++count_; }
  void writeImu(const std::vector<ImuReading>&) override {}
  void close() override {}
  size_t count() const override { return count_; }

 private:
  size_t count_ = 0;
};

TEST(RecorderInterface, DepthImagesOfTheirOwnTimeAreIgnoredUnlessAFormatTakesThem) {
  PlainRecorder recorder;
  EXPECT_NO_THROW(recorder.writeDepth(1, cv::Mat(3, 4, CV_16U)));
  EXPECT_EQ(recorder.count(), 0u);
}

}  // namespace
}  // namespace edge_mcl
