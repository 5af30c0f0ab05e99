/// Sensors of one moment have stamps of their own.

#include <gtest/gtest.h>
#include <boost/make_shared.hpp>

#include <Eigen/Geometry>
#include <cmath>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/localizer/imu_history.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"
#include "edge_mcl/nodes/messages/sensor_mounting.h"

namespace edge_mcl {
namespace {

Eigen::Matrix3d turnedBy(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
}

sensor_msgs::ImuPtr imuAt(double seconds, double angle) {
  auto message = boost::make_shared<sensor_msgs::Imu>();
  message->header.stamp = ros::Time(seconds);
  const Eigen::Quaterniond q(turnedBy(angle));
  message->orientation.x = q.x();
  message->orientation.y = q.y();
  message->orientation.z = q.z();
  message->orientation.w = q.w();
  return message;
}

double angleTo(const ImuOrientation& imu, double angle) {
  return Eigen::AngleAxisd(imu.R_world_imu.transpose() * turnedBy(angle)).angle();
}

/// The truth is a turn at constant rate. The nearest message would be off by 0.4 degrees at 1
/// rad/s.
TEST(ImuHistory, InterpolatesBetweenMessages) {
  ImuHistory history;
  for (int k = 0; k < 20; ++k) history.add(imuAt(10 + 0.02 * k, 0.02 * k));
  for (const double time : {0.0, 0.007, 0.1, 0.113, 0.379})
    EXPECT_NEAR(angleTo(history.at(ros::Time(10 + time)), time), 0, 1e-6) << time;
}

TEST(ImuHistory, AfterTheNewestTheNewestCounts) {
  ImuHistory history;
  history.add(imuAt(10, 0.3));
  EXPECT_NEAR(angleTo(history.at(ros::Time(10.03)), 0.3), 0, 1e-9);
  EXPECT_NEAR(angleTo(history.at(ros::Time(9.97)), 0.3), 0, 1e-9);
  EXPECT_THROW(history.at(ros::Time(10.06)), InputError);
  EXPECT_THROW(ImuHistory().at(ros::Time(10)), InputError);
}

TEST(ImuHistory, MessagesOfOneStampAreNoGap) {
  ImuHistory history;
  for (int k = 0; k < 3; ++k) history.add(imuAt(10, 0.3));
  EXPECT_NEAR(angleTo(history.at(ros::Time(10)), 0.3), 0, 1e-9);
}

TEST(ImuHistory, StartsAnewWhenTheClockIsSetBack) {
  ImuHistory history;
  history.add(imuAt(100, 0.3));
  history.add(imuAt(10, 0.1));
  EXPECT_THROW(history.at(ros::Time(100)), InputError);
}

TEST(ImuHistory, WithoutOrientationItSaysSo) {
  ImuHistory history;
  const sensor_msgs::ImuPtr message = imuAt(10, 0.3);
  message->orientation_covariance[0] = -1;
  history.add(message);
  EXPECT_THROW(history.at(ros::Time(10)), InputError);
}

/// A robot on a circle: the pose at any time is known in closed form.
class MovingBase : public ::testing::Test {
 protected:
  static Pose at(double time) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(time, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    pose.translation() = Eigen::Vector3d(std::cos(time), std::sin(time), 1);
    return pose;
  }
  MovingBase() {
    for (int k = 0; k <= 100; ++k)
      odometry_.setTransform(
          toTransformStamped(at(0.01 * k), ros::Time(10 + 0.01 * k), "odom", "base"), "test");
  }
  Pose motion(double moment, double stamp) const {
    return baseMotion(odometry_, "odom", "base", ros::Time(10 + moment), ros::Time(10 + stamp));
  }
  tf2::BufferCore odometry_;
};

/// 20 ms at 1 rad/s are 1.1 degrees and 2 cm, as much as a good pose is off.
TEST_F(MovingBase, IsBroughtToTheTimeOfTheMoment) {
  const Pose expected = at(0.5).inverse() * at(0.52);
  EXPECT_GT(rotationAngle(Pose::Identity(), expected), 1.1 * kDegree);
  EXPECT_LT((motion(0.5, 0.52).matrix() - expected.matrix()).norm(), 1e-6);
  EXPECT_LT((motion(0.5, 0.487).matrix() - (at(0.5).inverse() * at(0.487)).matrix()).norm(), 1e-4);
}

TEST_F(MovingBase, WithoutOdometryItStandsStill) {
  EXPECT_TRUE(motion(0.99, 1.05).isApprox(Pose::Identity()));
  EXPECT_TRUE(motion(0.5, 0.5).isApprox(Pose::Identity()));
  EXPECT_TRUE(motion(0.5, -9.9).isApprox(Pose::Identity()));
  EXPECT_TRUE(baseMotion(odometry_, "odometry", "base", ros::Time(10.1), ros::Time(10.2))
                  .isApprox(Pose::Identity()));
}

}  // namespace
}  // namespace edge_mcl
