#include "edge_mcl/core/depth/foreign_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "support/room_view.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

constexpr double kLeast = 0.1;  // m

/// The furnished rooms with a person, as wide as a door and 1.7 m tall, 1.4 m ahead of the camera.
class ForeignPointsTest : public testing::Test {
 protected:
  const CameraModel camera_ = test::pinhole(640, 480, 500);
  const Pose pose_ = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});
  const MeshModel model_ = test::furnishedRooms();
  const RayScene scene_{model_};

  static MeshModel withPerson() {
    MeshSoup soup;
    test::addBox(&soup, {0, 0, 0}, {8, 5, 2.6f}, 0, true);
    test::addBox(&soup, {1.7f, 1.5f, 0}, {2.1f, 2.1f, 1.7f});
    return weldMesh(std::move(soup), 1e-6, "room with a person");
  }
  DepthImage depthOf(const MeshModel& scene) const {
    DepthImage image;
    image.camera = camera_;
    image.depth = test::renderDepth(scene, camera_, pose_);
    image.origin = "depth";
    return image;
  }
  PoseGaussian pose(double position = 0, double angle = 0) const {
    PoseGaussian result;
    result.mean = pose_;
    result.covariance.diagonal().head<3>().setConstant(position * position);
    result.covariance.diagonal().tail<3>().setConstant(angle * angle);
    return result;
  }
  /// Noise of a Kinect: 1.4 mm at 1 m, growing with the square (Khoshelham and Oude Elberink,
  /// 2012).
  static void addNoise(uint64_t seed, cv::Mat* depth) {
    RandomSource random(seed);
    for (int y = 0; y < depth->rows; ++y)
      for (int x = 0; x < depth->cols; ++x) {
        float& z = depth->at<float>(y, x);
        z += static_cast<float>(0.0014 * random.normal()) * z * z;
      }
  }
  static double share(const ForeignPoints& found) {
    return static_cast<double>(found.points.size()) / static_cast<double>(found.compared);
  }
};

TEST_F(ForeignPointsTest, AnExactImageOfTheModelHasNone) {
  const ForeignPoints found = foreignPoints(depthOf(model_), scene_, pose(), {}, kLeast);
  EXPECT_GT(found.compared, 15000u);
  EXPECT_TRUE(found.points.empty());
  EXPECT_GT(found.of_model.size(), 0.95 * static_cast<double>(found.compared));
}

/// The person is compared with an image of the same room without it: a pixel whose depth differs
/// belongs to the person. The room of the model is furnished, but nothing of it is in front.
TEST_F(ForeignPointsTest, APersonIsFoundWholeAndNothingElse) {
  const DepthImage image = depthOf(withPerson());
  MeshSoup empty;
  test::addBox(&empty, {0, 0, 0}, {8, 5, 2.6f}, 0, true);
  const MeshModel room = weldMesh(std::move(empty), 1e-6, "room");
  const cv::Mat without = test::renderDepth(room, camera_, pose_);
  const RayScene scene(room);
  const ForeignPoints found = foreignPoints(image, scene, pose(), {}, kLeast);
  std::set<std::pair<int, int>> marked;
  for (const Eigen::Vector3f& point : found.points) {
    Eigen::Vector2d pixel;
    ASSERT_TRUE(camera_.project(point.cast<double>(), &pixel));
    marked.emplace(std::lround(pixel.x()), std::lround(pixel.y()));
  }
  const int step = static_cast<int>(found.spacing);
  int person = 0, missed = 0, wrong = 0;
  for (int y = 0; y < camera_.height; y += step)
    for (int x = 0; x < camera_.width; x += step) {
      const double nearer = without.at<float>(y, x) - image.depth.at<float>(y, x);
      const bool is_person = nearer > 1e-3, is_marked = marked.count({x, y}) > 0;
      person += is_person;
      // Feet stand nearer to the floor behind them than the smallest distance.
      missed += nearer > 2 * kLeast + 0.2 && !is_marked;
      wrong += is_marked && !is_person;
    }
  EXPECT_GT(person, 500);
  EXPECT_EQ(wrong, 0);
  EXPECT_LE(missed, person / 50);
}

/// Noise alone, and a pose that is as wrong as it says, make nothing foreign. Each seed draws a
/// pose error. Three standard deviations leave 0.3 % per axis, and the nearest surfaces count.
TEST_F(ForeignPointsTest, NoiseAndTheUncertaintyOfThePoseMakeNothingForeign) {
  const DepthImage exact = depthOf(model_);
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    DepthImage image = exact;
    image.depth = exact.depth.clone();
    addNoise(seed, &image.depth);
    RandomSource random(seed + 1000);
    PoseGaussian wrong = pose(0.02, 0.5 * M_PI / 180);
    Twist error;
    for (int k = 0; k < 6; ++k) error[k] = std::sqrt(wrong.covariance(k, k)) * random.normal();
    wrong.mean = pose_ * expSe3(error);
    EXPECT_LT(share(foreignPoints(image, scene_, wrong, {}, kLeast)), 0.01) << "seed " << seed;
  }
}

/// The agreement tells a right pose from a wrong one, with a person in view and Kinect noise. Wrong
/// poses are 0.3 to 1 m and 10 to 30 degrees off.
TEST_F(ForeignPointsTest, TheAgreementTellsWhetherThePoseIsRight) {
  MeshSoup soup;
  test::addBox(&soup, {1.7f, 1.5f, 0}, {2.1f, 2.1f, 1.7f});
  const cv::Mat person =
      test::renderDepth(weldMesh(std::move(soup), 1e-6, "person"), camera_, pose_);
  DepthImage image = depthOf(model_);
  cv::Mat in_front;
  cv::compare(person, 0, in_front, cv::CMP_GT);
  person.copyTo(image.depth, in_front);
  addNoise(1, &image.depth);
  RandomSource random(2);
  const PoseGaussian right = pose(0.02, 0.5 * M_PI / 180);
  int wrong_but_agreeing = 0;
  for (int i = 0; i < 100; ++i) {
    PoseGaussian near = right, far = right;
    Twist error;
    for (int k = 0; k < 6; ++k) error[k] = std::sqrt(right.covariance(k, k)) * random.normal();
    near.mean = pose_ * expSe3(error);
    EXPECT_GT(foreignPoints(image, scene_, near, {}, kLeast).agreement, 0.95);
    error.head<3>() = (0.3 + 0.7 * random.uniform()) * random.direction();
    error.tail<3>() = (10 + 20 * random.uniform()) * M_PI / 180 * random.direction();
    far.mean = pose_ * expSe3(error);
    wrong_but_agreeing += foreignPoints(image, scene_, far, {}, kLeast).agreement > 0.9;
  }
  EXPECT_LE(wrong_but_agreeing, 2);
}

/// Single wrong pixels, and lines of them at the edges of surfaces, are no things.
TEST_F(ForeignPointsTest, ScatteredPixelsAreLeftOut) {
  DepthImage image = depthOf(model_);
  RandomSource random(5);
  for (int y = 0; y < image.depth.rows; ++y)
    for (int x = 0; x < image.depth.cols; ++x)
      if (random.uniform() < 0.02) image.depth.at<float>(y, x) = 0.4F;
  image.depth.colRange(300, 306).setTo(0.6F);
  EXPECT_LT(share(foreignPoints(image, scene_, pose(), {}, kLeast)), 0.001);
}

/// A thing before the open side of a model may stand before a wall that the model lacks.
TEST_F(ForeignPointsTest, WhereTheModelHasNoSurfaceNothingIsForeign) {
  MeshSoup soup;
  test::addBox(&soup, {-3, 9, 0}, {-2, 10, 1});
  const MeshModel far = weldMesh(std::move(soup), 1e-6, "far box");
  const RayScene scene(far);
  const ForeignPoints found = foreignPoints(depthOf(model_), scene, pose(), {}, kLeast);
  EXPECT_EQ(found.compared, 0u);
  EXPECT_TRUE(found.points.empty());
}

/// The edge of a counter is a step of the depth along a row of the image. A pose that is a little
/// wrong sees the counter where the model has the wall behind. The row must not become part of the
/// person who stands there.
TEST_F(ForeignPointsTest, AStepOfTheDepthBesideAPersonIsNotForeign) {
  const auto counter = [](bool with_person) {
    MeshSoup soup;
    test::addBox(&soup, {0, 0, 0}, {8, 5, 2.6f}, 0, true);
    test::addBox(&soup, {1.0f, 0.5f, 0}, {2.0f, 4.5f, 1.0f});
    if (with_person) test::addBox(&soup, {2.1f, 2.2f, 0}, {2.4f, 2.8f, 1.7f});
    return weldMesh(std::move(soup), 1e-6, "room with a counter");
  };
  const MeshModel model = counter(false), real = counter(true);
  const RayScene scene(model);
  const Pose level = test::lookAlong({4.2, 2.5, 1.345}, {-1, 0, 0});
  for (const double turn : {-0.02, 0.0, 0.02}) {
    const Pose true_pose = level * expSe3((Twist() << 0, 0, 0, turn * M_PI / 180, 0, 0).finished());
    DepthImage image;
    image.camera = camera_;
    image.origin = "depth";
    image.depth = test::renderDepth(real, camera_, true_pose);
    const cv::Mat without = test::renderDepth(model, camera_, true_pose);
    PoseGaussian expected = pose(0.001, 0.02 * M_PI / 180);
    expected.mean = level;
    int wrong = 0;
    const ForeignPoints found = foreignPoints(image, scene, expected, {}, kLeast);
    for (const Eigen::Vector3f& point : found.points) {
      Eigen::Vector2d pixel;
      ASSERT_TRUE(camera_.project(point.cast<double>(), &pixel));
      const cv::Point at(static_cast<int>(std::lround(pixel.x())),
                         static_cast<int>(std::lround(pixel.y())));
      wrong += without.at<float>(at) - image.depth.at<float>(at) < 1e-3;
    }
    EXPECT_GT(found.points.size(), 500u);
    EXPECT_EQ(wrong, 0) << turn << " deg";
  }
}

/// Something that is farther away than the model is no foreign thing: the model is wrong there.
TEST_F(ForeignPointsTest, WhatIsBehindTheModelIsNotForeign) {
  DepthImage image = depthOf(model_);
  image.depth *= 1.3F;
  const ForeignPoints found = foreignPoints(image, scene_, pose(), {}, kLeast);
  EXPECT_TRUE(found.points.empty());
  EXPECT_LT(found.of_model.size(), 0.1 * static_cast<double>(found.compared));
}

TEST_F(ForeignPointsTest, BothKindsOfDepthImagesAndMissingDepthAreRead) {
  DepthImage image = depthOf(withPerson());
  const size_t whole = foreignPoints(image, scene_, pose(), {}, kLeast).points.size();
  DepthImage millimetres = image;
  image.depth.convertTo(millimetres.depth, CV_16U, 1000);
  EXPECT_NEAR(
      static_cast<double>(foreignPoints(millimetres, scene_, pose(), {}, kLeast).points.size()),
      static_cast<double>(whole), 0.01 * static_cast<double>(whole));
  image.depth.setTo(std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(foreignPoints(image, scene_, pose(), {}, kLeast).compared, 0u);
  image.depth = cv::Mat(10, 10, CV_32F);
  EXPECT_THROW(foreignPoints(image, scene_, pose(), {}, kLeast), InputError);
  image.depth = cv::Mat(480, 640, CV_8UC3);
  EXPECT_THROW(foreignPoints(image, scene_, pose(), {}, kLeast), InputError);
}

}  // namespace
}  // namespace edge_mcl
