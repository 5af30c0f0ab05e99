#include "edge_mcl/localization/objects/object_names.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

const CameraModel kCamera = test::pinhole();

/// A box 0.5 m wide and 4 m ahead of a camera at the origin that looks along z.
ObjectState boxAt(int number, double x) {
  ObjectState object;
  object.number = number;
  object.is_in_view = true;
  object.box = {Eigen::Vector3d(x - 0.25, -0.5, 4), Eigen::Vector3d(x + 0.25, 0.5, 4.3)};
  return object;
}

/// The same box as a network would find it: its front, in pixels.
ObjectNames::Found found(const std::string& name, double score, double x) {
  Eigen::Vector2d low, high;
  EXPECT_TRUE(kCamera.project(Eigen::Vector3d(x - 0.25, -0.5, 4), &low));
  EXPECT_TRUE(kCamera.project(Eigen::Vector3d(x + 0.25, 0.5, 4), &high));
  return {name, score, cv::Rect2d(cv::Point2d(low.x(), low.y()), cv::Point2d(high.x(), high.y()))};
}

TEST(ObjectNames, TheObjectAtTheSamePlaceGetsTheName) {
  ObjectNames names;
  const std::vector<ObjectState> objects{boxAt(7, -0.6), boxAt(9, 0.6)};
  for (int i = 0; i < 20; ++i) names.remember(0.1 * i, kCamera, Pose::Identity(), objects);
  names.hear(1.5, {found("person", 0.7, 0.6), found("chair", 0.4, -0.6)});
  EXPECT_EQ(names.nameOf(9), "") << "one image proves nothing";
  names.hear(1.6, {found("person", 0.7, 0.6), found("chair", 0.4, -0.6)});
  EXPECT_EQ(names.nameOf(9), "person");
  EXPECT_EQ(names.nameOf(7), "");
  EXPECT_EQ(names.nameOf(1), "");
}

TEST(ObjectNames, TheSurestNameIsGiven) {
  ObjectNames names;
  names.remember(0, kCamera, Pose::Identity(), {boxAt(1, 0)});
  for (int i = 0; i < 3; ++i) names.hear(0, {found("sofa", 0.5, 0), found("chair", 0.9, 0)});
  EXPECT_EQ(names.nameOf(1), "chair");
}

TEST(ObjectNames, OtherPlacesAndTimesAndObjectsOutOfViewGetNone) {
  ObjectNames names;
  ObjectState hidden = boxAt(2, 0.6);
  hidden.is_in_view = false;
  ObjectState behind = boxAt(3, 0);
  behind.box.translate(Eigen::Vector3d(0, 0, -4.1));  // around the camera
  for (int i = 0; i < 60; ++i)
    names.remember(0.1 * i, kCamera, Pose::Identity(), {boxAt(1, -0.6), hidden, behind});
  for (int i = 0; i < 5; ++i) {
    names.hear(5, {found("person", 0.9, 0.6), found("person", 0.9, 0)});
    names.hear(1, {found("person", 0.9, -0.6)});  // too long ago
  }
  for (const int number : {1, 2, 3}) EXPECT_EQ(names.nameOf(number), "") << number;
  // The clock went back: another flight.
  names.remember(0, kCamera, Pose::Identity(), {});
  names.hear(5, {found("person", 0.9, -0.6), found("person", 0.9, -0.6)});
  EXPECT_EQ(names.nameOf(1), "");
}

}  // namespace
}  // namespace edge_mcl
