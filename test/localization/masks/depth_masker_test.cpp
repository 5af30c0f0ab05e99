#include "edge_mcl/localization/masks/depth_masker.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// A wall of points 2 m ahead of a depth camera: columns of a 640 x 480 image, 4 pixels apart.
DepthMasker::Foreign wall(int from, int to, const Pose& T_base_depth = Pose::Identity()) {
  DepthMasker::Foreign foreign;
  foreign.T_base_depth = T_base_depth;
  foreign.focal_length = 500;
  foreign.points.spacing = 4;
  for (int y = 0; y < 480; y += 4)
    for (int x = from; x < to; x += 4)
      foreign.points.points.push_back(2 * Eigen::Vector3f(static_cast<float>(x - 319.5) / 500,
                                                          static_cast<float>(y - 239.5) / 500, 1));
  return foreign;
}

double share(const cv::Mat& mask) {
  return mask.empty() ? 0 : cv::countNonZero(mask) / static_cast<double>(mask.total());
}

const CameraModel kCamera = test::pinhole();

TEST(DepthMasker, TheThingAndAMarginAreMasked) {
  DepthMasker masker;
  const cv::Mat mask = masker.add(0, {wall(100, 200)}, kCamera, Pose::Identity(), 0.8, {});
  ASSERT_EQ(mask.size(), cv::Size(640, 480));
  EXPECT_EQ(cv::countNonZero(mask.colRange(98, 199)), 101 * 480);
  EXPECT_EQ(cv::countNonZero(mask.colRange(0, 96)), 0);
  EXPECT_EQ(cv::countNonZero(mask.colRange(201, 640)), 0);
}

/// The colour camera is 10 cm to the right of the depth camera. At 2 m this is 25 pixels.
TEST(DepthMasker, TheDepthCameraMayBeAnother) {
  DepthMasker masker;
  Pose T_base_camera = Pose::Identity();
  T_base_camera.translation().x() = 0.1;
  const cv::Mat mask = masker.add(0, {wall(100, 200)}, kCamera, T_base_camera, 0.8, {});
  EXPECT_EQ(cv::countNonZero(mask.colRange(76, 172)), 96 * 480);
  EXPECT_EQ(cv::countNonZero(mask.colRange(0, 70)), 0);
  EXPECT_EQ(cv::countNonZero(mask.colRange(182, 640)), 0);
}

TEST(DepthMasker, AnotherMaskIsKept) {
  DepthMasker masker;
  cv::Mat other = cv::Mat::zeros(480, 640, CV_8U);
  other.colRange(400, 500).setTo(1);
  const cv::Mat mask = masker.add(0, {wall(100, 200)}, kCamera, Pose::Identity(), 0.8, other);
  EXPECT_EQ(cv::countNonZero(mask.colRange(400, 500)), 100 * 480);
  EXPECT_EQ(cv::countNonZero(mask.colRange(98, 199)), 101 * 480);
  EXPECT_EQ(cv::countNonZero(other), 100 * 480) << "the caller's mask was changed";
  // Without depth images, the mask itself.
  EXPECT_EQ(masker.add(0, {}, kCamera, Pose::Identity(), 0.8, other).data, other.data);
}

/// A network masks a cupboard and a person in front of it. Depth knows the cupboard of the model.
TEST(DepthMasker, WhatIsOfTheModelIsTakenOutOfAnotherMask) {
  DepthMasker masker;
  DepthMasker::Foreign foreign = wall(100, 140);
  foreign.points.of_model = wall(200, 300).points.points;
  cv::Mat other = cv::Mat::zeros(480, 640, CV_8U);
  other.colRange(80, 400).setTo(1);
  const cv::Mat mask = masker.add(0, {foreign}, kCamera, Pose::Identity(), 0.8, other);
  EXPECT_EQ(cv::countNonZero(mask.colRange(80, 190)), 110 * 480);
  EXPECT_EQ(cv::countNonZero(mask.colRange(200, 296)), 0);
  EXPECT_EQ(cv::countNonZero(mask.colRange(310, 400)), 90 * 480);  // depth says nothing there
}

/// Seen from a wrong pose, all of a sudden the building lies in front of the model.
TEST(DepthMasker, AMaskThatGrowsAtOnceIsHeldBackForOneImage) {
  DepthMasker masker;
  const auto add = [&](int to) {
    return share(masker.add(0, {wall(0, to)}, kCamera, Pose::Identity(), 0.8, {}));
  };
  EXPECT_EQ(add(300), 0);
  EXPECT_GT(add(300), 0.4);
  EXPECT_GT(add(370), 0.55);
  EXPECT_EQ(add(600), 0);  // more than the largest share
  EXPECT_GT(add(370), 0.55);
  masker.forget();
  EXPECT_EQ(add(300), 0);
}

TEST(DepthMasker, EveryCameraHasAMemoryOfItsOwn) {
  DepthMasker masker;
  const std::vector<DepthMasker::Foreign> half{wall(0, 320)};
  masker.add(0, half, kCamera, Pose::Identity(), 0.8, {});
  EXPECT_EQ(share(masker.add(1, half, kCamera, Pose::Identity(), 0.8, {})), 0);
  EXPECT_GT(share(masker.add(0, half, kCamera, Pose::Identity(), 0.8, {})), 0.4);
}

TEST(DepthMasker, AModelWithoutFacesMasksNothing) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 2}, {1, 0, 2}};
  soup.lines = {{0, 1}};
  const LocalizationMap map(weldMesh(std::move(soup), 1e-6, "a line"), {});
  DepthImage image;
  image.camera = kCamera;
  image.depth = cv::Mat(480, 640, CV_32F, cv::Scalar(1));
  EXPECT_TRUE(DepthMasker::find(map, image, {}, Pose::Identity()).points.points.empty());
}

/// Depth images are needed when they make masks only.
TEST(DepthMasker, TheNeededImages) {
  Parameters params;
  EXPECT_EQ(neededImages(params), Cues::kEdges);
  params.tracking.mask_by_depth = true;
  EXPECT_EQ(neededImages(params), Cues::kBoth);
  params.likelihood.cues = Cues::kDepth;
  EXPECT_EQ(neededImages(params), Cues::kDepth);
}

}  // namespace
}  // namespace edge_mcl
