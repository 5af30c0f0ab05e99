#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/sim/flight_path.h"
#include "edge_mcl/sim/sensor_noise.h"

namespace edge_mcl {
namespace {

FlightPath curvedFlight(bool tilts = true) {
  return FlightPath::throughWaypoints({{0, {0, 0, 1}, 0},
                                       {2, {2, 0.5, 1.2}, 0.5},
                                       {4, {3, 2, 1.6}, 1.6},
                                       {7, {1, 3, 1.1}, 3.0},
                                       {10, {0, 1, 1.0}, -2.6}},
                                      tilts, "test");
}

/// The truth of the derivatives is the central difference.
TEST(CubicSpline, PassesThroughItsPointsSmoothly) {
  const std::vector<double> times{0, 1, 2.5, 3, 5}, values{1, -1, 0.5, 2, 0};
  const CubicSpline spline(times, values);
  for (size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(spline.at(times[i]), values[i], 1e-12);
  for (double t = 0.01; t < 4.99; t += 0.0173) {
    constexpr double kStep = 1e-5;
    EXPECT_NEAR(spline.at(t, 1), (spline.at(t + kStep) - spline.at(t - kStep)) / (2 * kStep), 1e-6);
    EXPECT_NEAR(spline.at(t, 2), (spline.at(t + kStep, 1) - spline.at(t - kStep, 1)) / (2 * kStep),
                1e-4);
  }
  EXPECT_NEAR(spline.at(0, 2), 0, 1e-12);
  EXPECT_NEAR(spline.at(5, 2), 0, 1e-12);
  EXPECT_EQ(spline.at(-1), 1);
  EXPECT_EQ(spline.at(9), 0);
  EXPECT_THROW(CubicSpline({0, 0}, {1, 2}), Error);
  // A straight line is its own spline.
  const CubicSpline line({0, 1, 4}, {1, 3, 9});
  for (double t = 0; t <= 4; t += 0.1) EXPECT_NEAR(line.at(t), 1 + 2 * t, 1e-12);
}

/// The z axis of the body must point along the thrust: the acceleration plus gravity.
TEST(FlightPath, TakesTheShorterWayRoundAndLeansIntoTheAcceleration) {
  const FlightPath path = curvedFlight();
  // The heading goes from 3.0 to -2.6 rad, which is 0.68 rad forward.
  EXPECT_LT(path.angularVelocity(8.5).norm(), 1);
  for (double t = 0.5; t < 10; t += 0.7) {
    const Pose pose = path.at(t);
    EXPECT_TRUE(isValid(pose));
    const Eigen::Vector3d thrust = path.acceleration(t) + Eigen::Vector3d(0, 0, 9.80665);
    EXPECT_NEAR(pose.linear().col(2).dot(thrust.normalized()), 1, 1e-9);
  }
  const FlightPath level = curvedFlight(false);
  EXPECT_NEAR(level.at(3).linear()(2, 2), 1, 1e-12);
  EXPECT_THROW(FlightPath::throughWaypoints({{0, {0, 0, 0}, 0}}, true, "one"), InputError);
  EXPECT_THROW(FlightPath::throughWaypoints({{0, {0, 0, 0}, 0}, {0, {1, 0, 0}, 0}}, true, "x"),
               InputError);
}

/// The poses are taken from one path. The path through them must be the same, between the poses,
/// too.
TEST(FlightPath, FliesRecordedPosesAgain) {
  const FlightPath path = curvedFlight();
  Trajectory poses;
  for (int i = 0; i <= 200; ++i) {
    StampedPose p;
    p.time = 0.05 * i;
    p.pose = path.at(p.time);
    poses.push_back(p);
  }
  const FlightPath again = FlightPath::throughPoses(poses, "test");
  for (double t = 0.3; t < 9.7; t += 0.033) {
    EXPECT_LT((again.at(t).translation() - path.at(t).translation()).norm(), 1e-4);
    // The second derivative, and with it the tilt, has corners at the waypoints.
    EXPECT_LT(rotationAngle(again.at(t), path.at(t)), 1e-2);
  }
}

/// Integrates readings from the true start, with the mean of two neighbouring readings.
Pose integrate(const FlightPath& path, const std::vector<ImuReading>& readings) {
  Eigen::Matrix3d rotation = path.at(readings[0].time).linear();
  Eigen::Vector3d position = path.at(readings[0].time).translation();
  Eigen::Vector3d velocity = path.velocity(readings[0].time);
  const Eigen::Vector3d gravity(0, 0, -FlightPath::kGravity);
  for (size_t i = 0; i + 1 < readings.size(); ++i) {
    const double dt = readings[i + 1].time - readings[i].time;
    const Eigen::Matrix3d next =
        rotation *
        expSo3(0.5 * dt * (readings[i].angular_velocity + readings[i + 1].angular_velocity));
    const Eigen::Vector3d acceleration =
        0.5 * (rotation * readings[i].specific_force + next * readings[i + 1].specific_force) +
        gravity;
    position += velocity * dt + 0.5 * dt * dt * acceleration;
    velocity += dt * acceleration;
    rotation = next;
  }
  Pose pose = Pose::Identity();
  pose.linear() = rotation;
  pose.translation() = position;
  return pose;
}

/// The truth is the end of the path.
TEST(Imu, PerfectReadingsIntegrateToTheTruth) {
  const FlightPath path = curvedFlight();
  // The rate of the tilt jumps at the waypoints. There the trapezoidal rule has an error of a part
  // of one step. So the error falls with the step.
  double last = 1;
  for (const double rate : {200.0, 1000.0, 5000.0}) {
    const auto readings = simulateImu(path, {rate, 0, 0, 0, 0}, 1);
    ASSERT_EQ(readings.size(), static_cast<size_t>(10 * rate + 1));
    const Pose end = integrate(path, readings);
    const double error = (end.translation() - path.at(10).translation()).norm();
    EXPECT_LT(error, 4 / rate);
    EXPECT_LT(error, last / 2);
    EXPECT_LT(rotationAngle(end, path.at(10)), 0.2 / rate);
    last = error;
  }
}

TEST(Imu, NoisyReadingsDriftAsTheirDensitiesSay) {
  const FlightPath path = curvedFlight();
  ImuNoise noise;
  noise.accelerometer_walk = noise.gyroscope_walk = 0;
  constexpr int kSeeds = 40;
  double angle2 = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Pose end = integrate(path, simulateImu(path, noise, seed));
    angle2 += std::pow(rotationAngle(end, path.at(10)), 2);
  }
  // White noise has the density d on each of three axes. After T seconds its variance is 3 d^2 T.
  // The ratio has 3 x 40 degrees of freedom, so its standard deviation is 0.13.
  const double expected = 3 * noise.gyroscope * noise.gyroscope * 10;
  EXPECT_NEAR(angle2 / kSeeds / expected, 1, 0.5);
}

TEST(Imu, AtRestItMeasuresGravity) {
  const FlightPath rest =
      FlightPath::throughWaypoints({{0, {1, 1, 1}, 0.7}, {20, {1, 1, 1}, 0.7}}, true, "rest");
  ImuNoise noise;
  noise.accelerometer_walk = noise.gyroscope_walk = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), turn = force;
  const auto readings = simulateImu(rest, noise, 3);
  for (const ImuReading& r : readings) {
    force += r.specific_force / static_cast<double>(readings.size());
    turn += r.angular_velocity / static_cast<double>(readings.size());
  }
  // The mean over 20 s has the standard deviation d / sqrt(20). Five of them are allowed.
  EXPECT_LT((force - Eigen::Vector3d(0, 0, 9.80665)).norm(), 5 * noise.accelerometer / 4.47);
  EXPECT_LT(turn.norm(), 5 * noise.gyroscope / 4.47);
}

TEST(Odometry, DriftsAsItsNoiseSays) {
  const FlightPath path = curvedFlight();
  OdometryNoise noise;
  noise.per_metre = noise.per_radian = noise.angle_deg = 0;
  constexpr int kSeeds = 60, kSteps = 100;
  double error2 = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    OdometrySimulator odometry(noise, seed);
    Pose last = Pose::Identity();
    for (int i = 0; i <= kSteps; ++i) last = odometry.next(0.1 * i, path.at(0.1 * i));
    const Pose truth = path.at(0).inverse() * path.at(10);
    error2 += (last.translation() - truth.translation()).squaredNorm();
  }
  // After 100 steps of 0.1 s the variance is 3 x 100 x position^2. The ratio has 180 degrees of
  // freedom, so its standard deviation is 0.11.
  EXPECT_NEAR(error2 / kSeeds / (3 * kSteps * noise.position * noise.position), 1, 0.45);
  OdometrySimulator perfect({0, 0, 0, 0}, 1);
  perfect.next(0, path.at(0));
  const Pose end = perfect.next(5, path.at(5));
  EXPECT_TRUE(end.isApprox(path.at(0).inverse() * path.at(5), 1e-9));
}

}  // namespace
}  // namespace edge_mcl
