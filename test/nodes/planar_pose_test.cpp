// Tests poses that RViz's "2D Pose Estimate" sets for a flying camera.
#include "edge_mcl/nodes/localizer/planar_pose.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// What RViz publishes, with its covariance (rviz, initial_pose_tool.cpp).
geometry_msgs::PoseWithCovariance clicked(double x, double y, double yaw) {
  geometry_msgs::PoseWithCovariance message;
  message.pose.position.x = x;
  message.pose.position.y = y;
  message.pose.orientation.z = std::sin(yaw / 2);
  message.pose.orientation.w = std::cos(yaw / 2);
  message.covariance[0] = message.covariance[7] = 0.25;
  message.covariance[35] = 0.06853891945200942;
  return message;
}

class PlanarPose : public testing::Test {
 protected:
  const LocalizationMap map_{test::furnishedRooms(), Parameters()};
};

TEST_F(PlanarPose, IsToldFromAWholePose) {
  EXPECT_TRUE(isPlanar(clicked(1, 2, 0.5)));
  geometry_msgs::PoseWithCovariance whole = clicked(1, 2, 0.5);
  whole.covariance[14] = 0.1;
  EXPECT_FALSE(isPlanar(whole));
  whole = clicked(1, 2, 0.5);
  whole.pose.position.z = 1.2;
  EXPECT_FALSE(isPlanar(whole));
  EXPECT_FALSE(isPlanar(geometry_msgs::PoseWithCovariance()));  // no covariance at all
}

/// The rooms are 2.6 m high, and nothing stands at (2, 2.5). So the height is between 0.2 and 2.4
/// m.
TEST_F(PlanarPose, HasTheHeightOfTheFreeSpace) {
  const PoseGaussian pose = completePlanar(clicked(2, 2.5, 0.5), map_, {});
  EXPECT_NEAR(pose.mean.translation().z(), 1.3, 0.15);
  const double sigma = std::sqrt(covarianceInMapAxes(pose)(2, 2));
  EXPECT_GT(3 * sigma, 1.0);
  EXPECT_LT(sigma, 1.0);
  EXPECT_NEAR(logSo3(pose.mean.linear()).z(), 0.5, 1e-9);
  // The desk at (1.5, 0.6) is 0.75 m high, so the robot is above it.
  EXPECT_NEAR(completePlanar(clicked(1.5, 0.6, 0), map_, {}).mean.translation().z(), 1.7, 0.15);
}

TEST_F(PlanarPose, HasHeightAndTiltOfThePoseBefore) {
  PlanarContext context;
  context.last = PoseGaussian();
  context.last->mean.translation() = Eigen::Vector3d(7, 1, 1.7);
  context.last->mean.linear() = rotationFromAngles(0.1, -0.2, 2.5);
  const PoseGaussian pose = completePlanar(clicked(2, 2.5, 0.5), map_, context);
  EXPECT_TRUE(pose.mean.translation().isApprox(Eigen::Vector3d(2, 2.5, 1.7), 1e-9));
  EXPECT_TRUE(
      (pose.mean.linear().transpose() * Eigen::Vector3d::UnitZ())
          .isApprox(context.last->mean.linear().transpose() * Eigen::Vector3d::UnitZ(), 1e-9));
  const Eigen::Vector3d forward = pose.mean.linear().col(0);
  EXPECT_NEAR(std::atan2(forward.y(), forward.x()), 0.5, 0.03);  // the roll turns it a little
}

TEST_F(PlanarPose, TheImuIsBelievedBeforeThePose) {
  PlanarContext context;
  context.last = PoseGaussian();
  context.up =
      UpReading{rotationFromAngles(0.2, 0, 0).transpose() * Eigen::Vector3d::UnitZ(), 0.02};
  const PoseGaussian pose = completePlanar(clicked(2, 2.5, 0), map_, context);
  EXPECT_TRUE(pose.mean.linear().isApprox(rotationFromAngles(0.2, 0, 0), 1e-9));
}

/// The camera is the base, so that x is to the right and z ahead.
TEST_F(PlanarPose, ACameraThatIsTheBaseLooksWhereTheArrowPoints) {
  PlanarContext context;
  context.is_camera_base = true;
  const PoseGaussian pose = completePlanar(clicked(2, 2.5, M_PI / 2), map_, context);
  EXPECT_TRUE(pose.mean.linear().col(2).isApprox(Eigen::Vector3d::UnitY(), 1e-9));
  EXPECT_TRUE(pose.mean.linear().col(1).isApprox(-Eigen::Vector3d::UnitZ(), 1e-9));
}

/// The rooms lie from 0 to 8 m along x and from 0 to 5 m along y.
TEST_F(PlanarPose, BesideTheModelIsTold) {
  EXPECT_EQ(hintBeside(map_.mesh(), {2, 2.5, 1}), "");
  EXPECT_EQ(hintBeside(map_.mesh(), {2, 2.5, 9}), "");  // above it
  const std::string hint = hintBeside(map_.mesh(), {-3, 2.5, 1});
  EXPECT_NE(hint.find("beside the model"), std::string::npos) << hint;
  EXPECT_NE(hintBeside(map_.mesh(), {2, 250, 1}), "");
}

/// Rays from such a place end the process in Embree.
TEST_F(PlanarPose, APlaceThatIsNotOnEarthIsRefused) {
  EXPECT_THROW(completePlanar(clicked(1e39, 1, 0), map_, {}), InputError);
  EXPECT_NO_THROW(completePlanar(clicked(5.4e6, 1, 0), map_, {}));
}

}  // namespace
}  // namespace edge_mcl
