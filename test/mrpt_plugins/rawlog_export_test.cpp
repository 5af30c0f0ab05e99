#include "edge_mcl/mrpt_plugins/rawlog_export.h"

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/serialization/CArchive.h>

#include <filesystem>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "support/error_text.h"
#include "support/small_rawlog.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;
using mrpt::obs::CActionRobotMovement3D;
using mrpt::obs::CObservationRobotPose;
using test::noisy;
using test::smallSetup;

/// A camera 0.2 m ahead of the base, which is x forward and z up.
const Pose kMounting = Pose(Eigen::Translation3d(0.2, 0, 0.1)) * opticalOnBody();

SequenceFrame frameAt(double time, const std::optional<Pose>& odometry) {
  SequenceFrame frame;
  frame.time = time;
  frame.odometry = odometry;
  return frame;
}

CActionRobotMovement3D::Ptr movementOf(const mrpt::obs::CActionCollection& actions) {
  EXPECT_EQ(actions.size(), 1u);
  return actions.getActionByClass<CActionRobotMovement3D>();
}

/// The base moves by 0.5 m ahead and turns by 0.3 rad to the left. The truth is this motion.
TEST(MakeAction, HoldsTheMotionOfTheBaseWithItsNoise) {
  Pose step = Pose::Identity();
  step.translation() = Eigen::Vector3d(0.5, 0, 0);
  step.linear() = rotationFromAngles(0, 0, 0.3);
  const Pose base = expSe3((Twist() << 1, 2, 3, 0.1, 0.2, 0.9).finished());
  const FilterParameters noise;
  const auto movement = movementOf(*makeAction(
      frameAt(10, base * kMounting), frameAt(10.4, base * step * kMounting), kMounting, noise));
  ASSERT_TRUE(movement);
  EXPECT_TRUE(toPose(movement->poseChange.mean).isApprox(step, 1e-9));
  EXPECT_TRUE(toPose(movement->rawOdometryIncrementReading).isApprox(step, 1e-9));
  EXPECT_NEAR(mrpt::Clock::toDouble(movement->timestamp), 10.4, 1e-6);
  // The motion stays level, so the covariance has the variances of the noise on its diagonal.
  const Vector6 sigma = odometryNoise(noise, step, 0.4);
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(movement->poseChange.cov(i, i), sigma[i] * sigma[i], 1e-8) << i;
}

TEST(MakeAction, WithoutOdometryTheNoiseIsThatOfAWalk) {
  const FilterParameters noise;
  for (const bool before : {true, false}) {
    const std::optional<Pose> known = Pose::Identity();
    const auto movement =
        movementOf(*makeAction(frameAt(10, before ? known : std::nullopt),
                               frameAt(10.5, before ? std::nullopt : known), kMounting, noise));
    ASSERT_TRUE(movement);
    EXPECT_TRUE(toPose(movement->poseChange.mean).isApprox(Pose::Identity(), 1e-12));
    const Vector6 sigma = walkNoise(noise, 0.5);
    for (int i = 0; i < 6; ++i)
      EXPECT_NEAR(movement->poseChange.cov(i, i), sigma[i] * sigma[i], 1e-8) << i;
  }
}

/// A sequence in memory with one frame. Its image and its mask are files.
class RawlogExport : public test::WithFolder {
 protected:
  RawlogExport() {
    sequence_.camera = smallSetup().camera;
    cv::imwrite(path("a.png"), cv::Mat(60, 80, CV_8UC3, cv::Scalar(80, 80, 80)));
    cv::Mat mask(60, 80, CV_8UC1, cv::Scalar(0));
    mask.colRange(0, 10) = 255;
    cv::imwrite(path("mask.png"), mask);
    frame_ = frameAt(12.5, std::nullopt);
    frame_.image_file = path("a.png");
    frame_.mask_file = path("mask.png");
  }
  /// Reads the next object of a rawlog.
  template <class Object>
  static typename Object::Ptr read(mrpt::io::CFileGZInputStream* stream) {
    return std::dynamic_pointer_cast<Object>(
        mrpt::serialization::archiveFrom(*stream).ReadObject());
  }

  Sequence sequence_;
  SequenceFrame frame_;
};

TEST_F(RawlogExport, ASensoryFrameHoldsImageMaskAndGroundTruth) {
  const Pose truth = expSe3((Twist() << 1, 2, 3, 0.1, 0.2, 0.9).finished());
  frame_.ground_truth = truth * kMounting;  // of the camera
  const auto frame = makeSensoryFrame(sequence_, frame_, kMounting, true);
  ASSERT_EQ(frame->size(), 2u);
  const auto image = frame->getObservationByClass<CObservationMaskedImage>();
  ASSERT_TRUE(image);
  EXPECT_EQ(image->sensorLabel, "camera");
  EXPECT_NEAR(mrpt::Clock::toDouble(image->timestamp), 12.5, 1e-6);
  EXPECT_EQ(image->image.asCvMatRef().type(), CV_8UC1);
  EXPECT_EQ(image->image.asCvMatRef().at<uint8_t>(7, 9), 80);
  EXPECT_EQ(cv::countNonZero(image->ignore_mask.asCvMatRef()), 600);
  EXPECT_TRUE(toPose(image->cameraPose).isApprox(kMounting, 1e-9));
  EXPECT_EQ(toCameraModel(image->cameraParams, "x").fx, 70);
  const auto pose = frame->getObservationByClass<CObservationRobotPose>();
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->sensorLabel, "ground_truth");
  EXPECT_EQ(pose->timestamp, image->timestamp);
  EXPECT_TRUE(toPose(pose->pose.mean).isApprox(truth, 1e-9));
}

TEST_F(RawlogExport, MaskAndGroundTruthMayBeMissing) {
  const auto frame = makeSensoryFrame(sequence_, frame_, kMounting, false);
  ASSERT_EQ(frame->size(), 1u);
  EXPECT_TRUE(frame->getObservationByClass<CObservationMaskedImage>()->ignore_mask.isEmpty());
}

TEST_F(RawlogExport, AnImageOrAMaskThatCannotBeReadIsAnError) {
  frame_.mask_file = path("missing_mask.png");
  test::expectError<InputError>("missing_mask.png",
                                [&] { makeSensoryFrame(sequence_, frame_, kMounting, true); });
  frame_.image_file = path("missing.png");
  test::expectError<InputError>("missing.png",
                                [&] { makeSensoryFrame(sequence_, frame_, kMounting, false); });
}

/// Before close() the file has the name FILE.part. An existing rawlog is never overwritten.
TEST_F(RawlogExport, ARawlogHasItsNameWhenItIsWhole) {
  const std::string file = (folder_ / "new.rawlog").string();
  {
    RawlogWriter writer(file, smallSetup(), FilterParameters());
    writer.write(noisy(1));
    EXPECT_FALSE(fs::exists(file));
    writer.close();
    EXPECT_TRUE(fs::exists(file));
    EXPECT_FALSE(fs::exists(file + ".part"));
  }
  const auto size = fs::file_size(file);
  EXPECT_THROW(RawlogWriter(file, smallSetup(), FilterParameters()), InputError);
  EXPECT_EQ(fs::file_size(file), size);
  // A rawlog without close(), as after an exception, never gets its name.
  const std::string other = (folder_ / "other.rawlog").string();
  RawlogWriter(other, smallSetup(), FilterParameters()).write(noisy(1));
  EXPECT_FALSE(fs::exists(other));
}

/// MRPT expects pairs of an action and a frame. The first action has no motion, because no image
/// lies before it.
TEST_F(RawlogExport, EveryImageBecomesAPair) {
  RecordingSetup setup = smallSetup();
  setup.T_base_camera = kMounting;
  RawlogWriter writer(path("pairs.rawlog"), setup, FilterParameters());
  const Pose step = expSe3((Twist() << 0.1, 0, 0, 0, 0, 0.05).finished());
  Pose base = expSe3((Twist() << 1, 2, 3, 0, 0, 0.9).finished());
  for (int k = 0; k < 3; ++k) {
    RecordedFrame frame = noisy(1 + k);
    frame.odometry = base * kMounting;
    writer.write(frame);
    writer.writeImu({{1.0 + k, Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, 9.8)}});
    base = base * step;
  }
  EXPECT_EQ(writer.count(), 3u);
  writer.close();
  mrpt::io::CFileGZInputStream stream(path("pairs.rawlog"));
  for (int k = 0; k < 3; ++k) {
    const auto actions = read<mrpt::obs::CActionCollection>(&stream);
    ASSERT_TRUE(actions);
    EXPECT_TRUE(toPose(movementOf(*actions)->poseChange.mean)
                    .isApprox(k == 0 ? Pose::Identity() : step, 1e-9));
    const auto frame = read<mrpt::obs::CSensoryFrame>(&stream);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->size(), 1u);
  }
  // The end of a compressed file is seen after a read beyond it.
  EXPECT_THROW(read<mrpt::obs::CSensoryFrame>(&stream), std::exception);
  EXPECT_TRUE(stream.checkEOF());
}

TEST_F(RawlogExport, AWriterThatIsClosedOrCannotWriteIsAnError) {
  RawlogWriter writer(path("closed.rawlog"), smallSetup(), FilterParameters());
  writer.write(noisy(1));
  writer.close();
  writer.close();  // does nothing
  test::expectError<Error>("closed.rawlog", [&] { writer.write(noisy(2)); });
  EXPECT_EQ(writer.count(), 1u);
  test::expectError<InputError>("cannot be written", [&] {
    RawlogWriter(path("nowhere/new.rawlog"), smallSetup(), FilterParameters());
  });
}

}  // namespace
}  // namespace edge_mcl
