// Tests the drawn model: the cut at a height, and clicks on it.
#include "edge_mcl/viewer/scene/model_shape.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/viewer/drawing/view_layout.h"
#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/scene/pose_pick.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

struct Box {
  MeshModel mesh;
  EdgeModel edges;
  Box() {
    MeshSoup soup;
    test::addBox(&soup, {0, 0, 0}, {2, 3, 1});
    mesh = weldMesh(std::move(soup), 1e-6, "box");
    edges = buildEdgeModel(&mesh, MapParameters());
  }
};

double areaOf(const ModelShape& shape) {
  double area = 0;
  for (const auto& t : shape.triangles)
    area += 0.5 * static_cast<double>(
                      (t.corners[1] - t.corners[0]).cross(t.corners[2] - t.corners[0]).norm());
  return area;
}

double lengthOf(const ModelShape& shape) {
  double length = 0;
  for (const auto& line : shape.lines) length += static_cast<double>((line[1] - line[0]).norm());
  return length;
}

/// The truth is the areas and lengths of a box of 2 x 3 x 1 m.
TEST(ModelShape, IsCutAtTheHeight) {
  const Box box;
  const ModelShape all = shapeBelow(box.mesh, box.edges, 5);
  EXPECT_NEAR(areaOf(all), 2 * (2 * 3 + 2 * 1 + 3 * 1), 1e-5);
  EXPECT_NEAR(lengthOf(all), 4 * (2 + 3 + 1), 1e-5);
  // The bottom and 0.4 m of the sides remain.
  const ModelShape low = shapeBelow(box.mesh, box.edges, 0.4F);
  EXPECT_NEAR(areaOf(low), 2 * 3 + 0.4 * 2 * (2 + 3), 1e-5);
  EXPECT_NEAR(lengthOf(low), 2 * (2 + 3) + 4 * 0.4, 1e-5);
  for (const auto& t : low.triangles)
    for (const auto& corner : t.corners) EXPECT_LE(corner.z(), 0.4F + 1e-6F);
  EXPECT_TRUE(shapeBelow(box.mesh, box.edges, -1).triangles.empty());
}

TEST(ModelShape, ARayMeetsWhatIsNearest) {
  const Box box;
  const ModelShape shape = shapeBelow(box.mesh, box.edges, 0.4F);
  Eigen::Vector3f hit;
  // This ray goes through the open top to the bottom.
  ASSERT_TRUE(firstHit(shape, {0.5F, 1, 4}, {0, 0, -2}, &hit));
  EXPECT_LT((hit - Eigen::Vector3f(0.5F, 1, 0)).norm(), 1e-5F);
  // This ray comes from the side and meets the near wall.
  ASSERT_TRUE(firstHit(shape, {5, 1, 0.2F}, {-1, 0, 0}, &hit));
  EXPECT_LT((hit - Eigen::Vector3f(2, 1, 0.2F)).norm(), 1e-5F);
  // These rays pass above the remaining part and away from it.
  EXPECT_FALSE(firstHit(shape, {5, 1, 0.7F}, {-1, 0, 0}, &hit));
  EXPECT_FALSE(firstHit(shape, {5, 1, 0.2F}, {1, 0, 0}, &hit));
}

TEST(PosePick, HeadsWhereTheMouseWasDrawn) {
  ViewMoment moment;
  moment.T_base_camera = opticalOnBody();  // the camera looks along the x axis of the base
  const PoseGaussian east = poseFromPick(moment, {1, 2, 0}, {3, 2, 0});
  EXPECT_LT((east.mean.translation() - Eigen::Vector3d(1, 2, 1.2)).norm(), 1e-9);
  EXPECT_LT((east.mean.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitX()).norm(),
            1e-9);
  const PoseGaussian north = poseFromPick(moment, {1, 2, 0}, {1, 4, 0});
  EXPECT_LT((north.mean.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            1e-9);
  // A click without a direction keeps the heading.
  moment.has_pose = true;
  moment.estimate.mean.linear() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const PoseGaussian kept = poseFromPick(moment, {1, 2, 0}, {1.05, 2, 0});
  EXPECT_LT((kept.mean.linear() - moment.estimate.mean.linear()).norm(), 1e-9);
}

/// The base may have any axes. In a sequence directory the base is the optical frame of the camera.
TEST(PosePick, TheCameraLooksAlongTheGroundWhateverAxesItsBaseHas) {
  ViewMoment moment;
  moment.has_camera = true;
  const Pose turned(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  for (const Pose& mounting : {Pose::Identity(), turned, opticalOnBody()}) {
    moment.T_base_camera = mounting;
    const PoseGaussian pose = poseFromPick(moment, {1, 2, 0}, {1, 4, 0});
    const Eigen::Matrix3d camera = (pose.mean * mounting).linear();
    EXPECT_LT((camera.col(2) - Eigen::Vector3d::UnitY()).norm(), 1e-9) << "where it looks";
    EXPECT_LT((camera.col(1) + Eigen::Vector3d::UnitZ()).norm(), 1e-9) << "upright";
  }
  // The camera looks down, and its base is level.
  moment.T_base_camera.linear() =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const PoseGaussian level = poseFromPick(moment, {1, 2, 0}, {1, 2, 0});
  EXPECT_LT((level.mean.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
}

TEST(ViewLayout, FillsTheWindowWithoutOverlap) {
  for (const cv::Size image : {cv::Size(), cv::Size(640, 480), cv::Size(752, 480),
                               cv::Size(1920, 1080), cv::Size(480, 640), cv::Size(4000, 10)})
    for (const cv::Size window : {cv::Size(1280, 720), cv::Size(640, 400), cv::Size(3840, 2160)}) {
      const ViewLayout l = layoutOf(window, image);
      cv::Mat covered(window, CV_8U, cv::Scalar(0));
      for (const cv::Rect& part : {l.space, l.legend, l.strips, l.edges, l.masks}) {
        ASSERT_EQ(part & cv::Rect({0, 0}, window), part);
        covered(part) += 1;
      }
      EXPECT_EQ(cv::countNonZero(covered == 1), window.area());
      EXPECT_EQ(l.space.width % 4, 0) << "see layoutOf";
    }
}

TEST(ViewParameters, ListAllFaultsAndNameTheNearest) {
  ViewParameters params;
  params.width = 641;
  params.model_style = "glass";
  params.zoom = 0;
  try {
    params.validate();
    FAIL();
  } catch (const ParameterError& e) {
    for (const char* name : {"width", "model_style", "zoom"})
      EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
  }
  try {
    params.set("modelstyle", "ghost");
    FAIL();
  } catch (const ParameterError& e) {
    EXPECT_NE(std::string(e.what()).find("model_style"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace edge_mcl
