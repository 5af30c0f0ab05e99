#include "edge_mcl/mrpt_plugins/CEdgeMonteCarloLocalization3D.h"

#include <gtest/gtest.h>
#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <cmath>
#include <memory>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "support/error_text.h"
#include "support/mrpt_room.h"

namespace edge_mcl {
namespace {

std::shared_ptr<CEdgeMap> roomMap(uint64_t seed, bool refine = true) {
  Parameters params;
  params.filter.seed = seed;
  params.filter.particles = 300;
  params.refinement.enabled = refine;
  return std::make_shared<CEdgeMap>(test::roomFile(), params);
}

PoseGaussian startNear(const Pose& base) {
  PoseGaussian start;
  start.mean = base * expSe3((Twist() << 0.04, -0.03, 0.05, 0.01, -0.015, 0.02).finished());
  start.covariance.diagonal() << 25e-4, 25e-4, 25e-4, 4e-4, 4e-4, 4e-4;
  return start;
}

/// One step of the filter, without MRPT's particle filter around it.
void step(CEdgeMonteCarloLocalization3D* filter, const mrpt::obs::CActionCollection* action,
          const mrpt::obs::CSensoryFrame* observation) {
  filter->prediction_and_update_pfStandardProposal(action, observation, {});
}

/// A frame with an observation that the map cannot use. @param time seconds
mrpt::obs::CSensoryFrame frameAt(double time) {
  auto odometry = std::make_shared<mrpt::obs::CObservationOdometry>();
  odometry->timestamp = mrpt::Clock::fromDouble(time);
  mrpt::obs::CSensoryFrame frame;
  frame.insert(odometry);
  return frame;
}

/// The truth is the pose of the rendered image. Two runs with one seed must give equal particles.
TEST(Filter, ConvergesInARenderedRoomAndIsReproducible) {
  const Pose base = test::kView * opticalOnBody().inverse();
  mrpt::obs::CSensoryFrame frame;
  frame.insert(test::roomObservation(opticalOnBody()));
  std::vector<double> first;
  for (int run = 0; run < 2; ++run) {
    CEdgeMonteCarloLocalization3D filter(roomMap(5));
    filter.initialize(startNear(base));
    mrpt::bayes::CParticleFilter particle_filter;
    for (int k = 0; k < 3; ++k) particle_filter.executeOn(filter, nullptr, &frame);
    const auto [covariance, mean] = filter.getCovarianceAndMean();
    EXPECT_LT((toPose(mean).translation() - base.translation()).norm(), 0.02);
    EXPECT_LT(rotationAngle(toPose(mean), base), 0.4 * M_PI / 180);
    EXPECT_GT(covariance(0, 0), 0);
    EXPECT_GT(filter.report().tempering, 0);
    std::vector<double> values;
    for (size_t i = 0; i < filter.size(); ++i) values.push_back(filter.getParticlePose(i).x);
    if (run == 0)
      first = values;
    else
      EXPECT_EQ(values, first);
  }
}

TEST(Filter, SidewaysAndVerticalOdometryMovesParticlesWithoutTurningThem) {
  // The 6-DoF motion model of MRPT is made for ground robots. This filter composes increments on
  // SE(3).
  for (const Eigen::Vector3d& step : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
    CEdgeMonteCarloLocalization3D filter(roomMap(6));
    PoseGaussian start;
    start.covariance.diagonal().setConstant(1e-12);
    filter.initialize(start);
    mrpt::obs::CActionRobotMovement3D movement;
    movement.poseChange.mean = toMrpt(Pose(Eigen::Translation3d(step)));
    mrpt::obs::CActionCollection actions;
    actions.insert(movement);
    mrpt::bayes::CParticleFilter().executeOn(filter, &actions, nullptr);
    for (size_t i = 0; i < filter.size(); ++i) {
      const Pose p = toPose(filter.getParticlePose(i));
      // Noise of 4 %, five standard deviations.
      EXPECT_LT((p.translation() - step).norm(), 0.04 * 5);
      EXPECT_LT(rotationAngle(p, Pose::Identity()), 1e-3);
    }
  }
}

/// The particles lie uniformly in x from 1 to 1.1 m, so their mean is 1.05 m.
TEST(Filter, ParticlesSetThroughTheBaseClassAreTaken) {
  CEdgeMonteCarloLocalization3D filter(roomMap(7));
  filter.resetUniform({1, 2, 1, 0, 0, 0}, {1.1, 2.1, 1.1, 0.1, 0, 0}, 300);
  mrpt::bayes::CParticleFilter().executeOn(filter, nullptr, nullptr);
  EXPECT_NEAR(filter.estimate().mean.translation().x(), 1.05, 0.03);
}

TEST(Filter, BadInputIsAnErrorAndNotAPose) {
  CEdgeMonteCarloLocalization3D filter(roomMap(8));
  PoseGaussian start;
  start.mean.translation().x() = NAN;
  EXPECT_THROW(filter.initialize(start), InputError);
  filter.initialize(startNear(test::kView));
  mrpt::obs::CActionRobotMovement3D movement;
  movement.poseChange.mean.x(NAN);
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  EXPECT_THROW(mrpt::bayes::CParticleFilter().executeOn(filter, &actions, nullptr), std::exception);
}

/// The steps of a robot on the ground: half a metre ahead, then a quarter turn to the left.
TEST(Filter, OdometryInThePlaneIsTakenToo) {
  CEdgeMonteCarloLocalization3D filter(roomMap(9));
  PoseGaussian start;
  start.covariance.diagonal().setConstant(1e-12);
  filter.initialize(start);
  mrpt::obs::CActionRobotMovement2D movement;
  mrpt::obs::CActionRobotMovement2D::TMotionModelOptions options;
  movement.computeFromOdometry({0.5, 0, M_PI / 2}, options);
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  step(&filter, &actions, nullptr);
  Pose expected = Pose::Identity();
  expected.translation().x() = 0.5;
  expected.linear() = rotationFromAngles(0, 0, M_PI / 2);
  const Pose& mean = filter.estimate().mean;
  // MRPT takes the mean of its own model of the motion, which is the odometry itself.
  EXPECT_LT((mean.translation() - expected.translation()).norm(), 1e-6);
  EXPECT_LT(rotationAngle(mean, expected), 1e-6);
}

/// Frames without an image only tell the time. Without a movement the base may walk or fly. The
/// first frame has no frame before it, so no time passes.
TEST(Filter, WithoutAMovementTheParticlesSpreadWithTime) {
  CEdgeMonteCarloLocalization3D filter(roomMap(10));
  const PoseGaussian start = startNear(test::kView);
  filter.initialize(start);
  const auto frame1 = frameAt(100), frame2 = frameAt(100.5);
  step(&filter, nullptr, &frame1);
  EXPECT_TRUE(filter.estimate().covariance.isApprox(start.covariance, 1e-12));
  step(&filter, nullptr, &frame2);
  const Vector6 sigma = walkNoise(Parameters().filter, 0.5);
  Matrix6 expected = start.covariance + Matrix6(sigma.cwiseAbs2().asDiagonal());
  // Nothing is known of the velocity: 0.5 m/s and 0.5 rad/s, forgotten over 5 s.
  const double distance = 0.5 * 5 * (1 - std::exp(-0.5 / 5));
  expected.diagonal().array() += distance * distance;
  EXPECT_TRUE(filter.estimate().covariance.isApprox(expected, 1e-9));
  EXPECT_EQ(filter.report().passes, 0);  // there was no image
}

TEST(Filter, ATimeThatGoesBackIsAnError) {
  CEdgeMonteCarloLocalization3D filter(roomMap(11));
  filter.initialize(startNear(test::kView));
  const auto later = frameAt(100), earlier = frameAt(99);
  step(&filter, nullptr, &later);
  test::expectError<InputError>("goes back", [&] { step(&filter, nullptr, &earlier); });
  filter.initialize(startNear(test::kView));  // the clock may begin anew with a new pose
  step(&filter, nullptr, &earlier);
}

TEST(Filter, AMapWithoutAModelIsAnError) {
  EXPECT_THROW(CEdgeMonteCarloLocalization3D(std::make_shared<CEdgeMap>()), Error);
}

/// MRPT's own resampling needs unequal weights. It must find equal ones.
TEST(Filter, AfterAnImageTheParticlesHaveEqualWeights) {
  const auto map = roomMap(12);
  CEdgeMonteCarloLocalization3D filter(map);
  filter.initialize(startNear(test::kView * opticalOnBody().inverse()));
  mrpt::obs::CSensoryFrame frame;
  frame.insert(test::roomObservation(opticalOnBody()));
  step(&filter, nullptr, &frame);
  EXPECT_EQ(filter.m_particles.size(),
            static_cast<size_t>(map->localization().params().filter.particles));
  for (const auto& particle : filter.m_particles) EXPECT_EQ(particle.log_w, 0);
  EXPECT_GE(filter.report().passes, 1);
}

TEST(Filter, MeanAndCovarianceAreThoseOfTheEstimate) {
  CEdgeMonteCarloLocalization3D filter(roomMap(13));
  const PoseGaussian start = startNear(test::kView);
  filter.initialize(start);
  mrpt::poses::CPose3D mean;
  filter.getMean(mean);
  EXPECT_TRUE(toPose(mean).isApprox(start.mean, 1e-12));
  const auto [covariance, same_mean] = filter.getCovarianceAndMean();
  EXPECT_TRUE(toPose(same_mean).isApprox(start.mean, 1e-12));
  const auto expected = toMrptCovariance(start);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) EXPECT_EQ(covariance(i, j), expected(i, j));
}

}  // namespace
}  // namespace edge_mcl
