#include "edge_mcl/sim/live_flight.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/sim/flight_path.h"
#include "edge_mcl/sim/sensor_noise.h"

namespace edge_mcl {
namespace {

bool everywhere(const Eigen::Vector3d&, const Eigen::Vector3d&) { return true; }

/// Commands for 3 s, and then 5 s without commands.
TEST(LiveFlight, ReachesTheCommandedVelocityAndHoversWithoutCommands) {
  LiveFlight flight(Pose::Identity(), {}, everywhere);
  double time = 0;
  flight.advance(time);
  for (; time < 3; time += 0.01) {
    flight.command(time, {1, 0, 0.2}, 0);
    flight.advance(time);
  }
  EXPECT_TRUE(flight.velocity().isApprox(Eigen::Vector3d(1, 0, 0.2), 0.02));
  for (; time < 8; time += 0.01) flight.advance(time);
  EXPECT_LT(flight.velocity().norm(), 0.01);
  EXPECT_TRUE(flight.pose().linear().isIdentity(0.01));
}

/// To accelerate forward the body tilts forward. The tangent of the angle is a / g.
TEST(LiveFlight, TiltsToAccelerate) {
  LiveFlight flight(Pose::Identity(), {}, everywhere);
  flight.advance(0);
  double steepest = 0;
  for (double t = 0.005; t < 1; t += 0.005) {
    flight.command(t, {2, 0, 0}, 0);
    flight.advance(t);
    const Eigen::Vector3d up = flight.pose().linear().col(2), a = flight.acceleration();
    EXPECT_NEAR(std::atan2(up.x(), up.z()), std::atan2(a.x(), FlightPath::kGravity + a.z()), 1e-9);
    steepest = std::max(steepest, up.x());
  }
  EXPECT_GT(steepest, 0.15);
  EXPECT_LT(flight.acceleration().norm(), 3.001);
}

TEST(LiveFlight, TurnsWithTheCommandInItsOwnAxes) {
  LiveFlight flight(Pose::Identity(), {}, everywhere);
  double time = 0;
  flight.advance(time);
  for (; time < 2; time += 0.01) {
    flight.command(time, {0, 0, 0}, 0.8);
    flight.advance(time);
  }
  EXPECT_NEAR(flight.angularVelocity().z(), 0.8, 1e-3);
  const double yaw = std::atan2(flight.pose().linear()(1, 0), flight.pose().linear()(0, 0));
  EXPECT_NEAR(yaw, 0.8 * (2 - 0.1), 0.02);  // the yaw is 0.1 s behind the command
  for (; time < 5; time += 0.01) {
    flight.command(time, {1, 0, 0}, 0);
    flight.advance(time);
  }
  const Eigen::Vector3d heading = flight.pose().linear().col(0);
  EXPECT_GT(flight.velocity().normalized().dot(heading.normalized()), 0.999);
}

/// The wall is at x = 1 m.
TEST(LiveFlight, StopsAtWalls) {
  const auto free = [](const Eigen::Vector3d&, const Eigen::Vector3d& b) { return b.x() < 1; };
  LiveFlight flight(Pose::Identity(), {}, free);
  bool stopped = false;
  flight.advance(0);
  for (double t = 0.01; t < 5; t += 0.01) {
    flight.command(t, {2, 0, 0}, 0);
    stopped |= !flight.advance(t);
    ASSERT_LT(flight.pose().translation().x(), 1);
  }
  EXPECT_TRUE(stopped);
  EXPECT_THROW(flight.command(6, {NAN, 0, 0}, 0), InputError);
}

/// A camera may ask for a pose in the middle between two IMU readings, or almost at one.
TEST(LiveFlight, TellsWhereItIsAroundNowAndBearsShortSteps) {
  LiveFlight flight(Pose::Identity(), {}, everywhere);
  flight.advance(0);
  Pose before = flight.pose();
  for (int i = 1; i <= 60; ++i) {
    before = flight.pose();
    flight.command(i * 0.01, {1, 0.5, 0}, 0.8);
    flight.advance(i * 0.01);
  }
  EXPECT_LT((flight.poseNear(0.59).translation() - before.translation()).norm(), 5e-4);
  EXPECT_LT(rotationAngle(flight.poseNear(0.59), before), 1e-9);
  EXPECT_GT((flight.poseNear(0.61).translation() - flight.pose().translation()).norm(), 2e-3);
  const Eigen::Vector3d turn = flight.angularVelocity();
  flight.advance(0.6 + 1e-15);
  EXPECT_LT((flight.angularVelocity() - turn).norm(), 1e-6);
}

/// A perfect sensor measures the specific force. Turned into map axes and without gravity it must
/// integrate to the velocity.
TEST(LiveFlight, ItsInertialReadingsIntegrateToItsMotion) {
  LiveFlight flight(Pose::Identity(), {}, everywhere);
  ImuNoise none;
  none.accelerometer = none.gyroscope = none.accelerometer_walk = none.gyroscope_walk = 0;
  ImuSensor sensor(none, 1);
  const double dt = 1 / none.rate;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Matrix3d attitude = Eigen::Matrix3d::Identity();
  flight.advance(0);
  for (int i = 1; i < 800; ++i) {
    const double t = i * dt;
    flight.command(t, {std::sin(t), std::cos(2 * t), 0.3}, 0.5);
    flight.advance(t);
    const ImuReading reading =
        sensor.read(t, flight.pose().linear(), flight.angularVelocity(), flight.acceleration());
    attitude = attitude * expSo3(reading.angular_velocity * dt);
    velocity +=
        (attitude * reading.specific_force - Eigen::Vector3d(0, 0, FlightPath::kGravity)) * dt;
  }
  EXPECT_LT(rotationAngle(Pose(attitude), Pose(flight.pose().linear())), 1e-9);
  EXPECT_LT((velocity - flight.velocity()).norm(), 1e-9);
}

}  // namespace
}  // namespace edge_mcl
