#include "edge_mcl/core/depth/depth_likelihood.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Eigenvalues>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"
#include "support/depth_scenes.h"
#include "support/random_points.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::anywhere;
using test::plainDistance;
using test::Random;
using test::roomDepth;
using test::roomField;

const Pose kView = test::roomView();

Pose disturbed(Random* random, double position, double angle) {
  Twist xi;
  xi << position * anywhere(random), angle * anywhere(random);
  return kView * expSe3(xi);
}

TEST(DepthLikelihood, AgreesWithTheFormulaOnTrueDistances) {
  // The truth is the formula of the score with brute-force distances. The field is exact beside
  // planes. A fifth of it is near edges, where its linear continuation has an error of up to some
  // centimetres (see ReadsTheTrueDistance).
  const MeshModel mesh = test::furnishedRooms();
  const DepthParameters params;
  const DepthLikelihood likelihood(roomField(), params);
  const DepthPoints points = makeDepthPoints(roomDepth(), params);
  Random random(5);
  for (int k = 0; k < 20; ++k) {
    const Pose pose = disturbed(&random, 0.03, 0.01);
    double sum = 0;
    for (size_t i = 0; i < points.count; ++i) {
      const double d =
          plainDistance(mesh, pose * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]));
      const double noise = params.sigma_per_square_metre * points.z[i] * points.z[i];
      const double sigma = std::sqrt(params.sigma * params.sigma + noise * noise);
      sum +=
          std::log(params.clutter + (1 - params.clutter) * params.truncation * std::sqrt(2 / M_PI) /
                                        sigma * std::exp(-d * d / (2 * sigma * sigma)));
    }
    const double expected =
        params.independent_points * points.returned * sum / static_cast<double>(points.count);
    EXPECT_NEAR(likelihood.evaluate(points, {pose}).front().log_likelihood, expected,
                0.02 * std::abs(expected) + 1);
  }
}

/// The kernel is compared with evaluateSlowly(), near the true pose and outside the model.
TEST(DepthLikelihood, VectorUnitAndSlowReferenceAgree) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  const DepthPoints points = makeDepthPoints(roomDepth(), DepthParameters());
  Random random(6);
  std::vector<Pose> poses;
  poses.reserve(501);
  for (int i = 0; i < 500; ++i) poses.push_back(disturbed(&random, 0.3, 0.2));
  poses.push_back(test::lookAlong({50, 50, 50}, {1, 0, 0}));  // all points lie outside the model
  const std::vector<DepthScore> scores = likelihood.evaluate(points, poses);
  for (size_t i = 0; i < poses.size(); ++i) {
    const DepthScore slow = likelihood.evaluateSlowly(points, poses[i]);
    // A point within the rounding of single precision from the border of a voxel may read the
    // neighbouring voxel. Near an edge the two differ by centimetres. One such point may shift the
    // mean of 500 points by this much.
    EXPECT_NEAR(scores[i].log_likelihood, slow.log_likelihood, 0.4);
    EXPECT_NEAR(scores[i].agreement, slow.agreement, 0.003);
  }
}

TEST(DepthLikelihood, SameBitsAloneInABatchAndOnAnyNumberOfThreads) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  const DepthPoints points = makeDepthPoints(roomDepth(), DepthParameters());
  Random random(7);
  std::vector<Pose> poses;
  poses.reserve(333);
  for (int i = 0; i < 333; ++i) poses.push_back(disturbed(&random, 0.2, 0.1));
  const std::vector<DepthScore> all = likelihood.evaluate(points, poses);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<DepthScore> again = likelihood.evaluate(points, poses);
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(all[i].log_likelihood, again[i].log_likelihood);
    EXPECT_EQ(likelihood.evaluate(points, {poses[i]}).front().log_likelihood,
              all[i].log_likelihood);
  }
}

/// Without points the score is exactly zero.
TEST(DepthLikelihood, NothingSaysNothingAndNaNIsAnError) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  EXPECT_EQ(likelihood.evaluate(DepthPoints(), {kView}).front().log_likelihood, 0);
  Pose bad = kView;
  bad.translation().x() = NAN;
  EXPECT_THROW(likelihood.evaluate(DepthPoints(), {bad}), Error);
}

/// The truth is the central difference of evaluateSlowly().
TEST(DepthLikelihood, GradientIsTheDerivative) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  const DepthPoints points = makeDepthPoints(roomDepth(), DepthParameters());
  Random random(8);
  for (int k = 0; k < 10; ++k) {
    const Pose pose = disturbed(&random, 0.05, 0.03);
    const NormalEquations n = likelihood.linearize(points, pose, 0);
    for (int axis = 0; axis < 6; ++axis) {
      // The step is short, so that hardly any point changes its voxel.
      constexpr double kStep = 1e-7;
      const Twist xi = kStep * Twist::Unit(axis);
      const double numeric =
          (likelihood.evaluateSlowly(points, pose * expSe3(xi)).log_likelihood -
           likelihood.evaluateSlowly(points, pose * expSe3(-xi)).log_likelihood) /
          (2 * kStep);
      EXPECT_NEAR(n.g[axis], numeric, 1e-3 * n.g.norm() + 1e-3) << axis;
    }
  }
}

/// Exact depths z are changed by b z^2. Five estimates must find the known b.
TEST(DepthLikelihood, ABiasIsFoundFromDepthsNearAndFar) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  for (const double b : {-0.003, 0.0015, 0.004}) {
    DepthImage image = roomDepth();
    for (int y = 0; y < image.depth.rows; ++y)
      for (int x = 0; x < image.depth.cols; ++x) {
        float& z = image.depth.at<float>(y, x);
        z -= static_cast<float>(b) * z * z;
      }
    DepthBias bias{0, 0.004 * 0.004};
    const DepthPoints points = makeDepthPoints(image, DepthParameters());
    for (int i = 0; i < 5; ++i) {
      const DepthPoints better = withoutBias(points, bias);
      const DepthBias rest = likelihood.remainingBias(better, kView, 1e-6 * Matrix6::Identity());
      bias.mean += rest.mean;
      EXPECT_LT(rest.variance, bias.variance);
    }
    EXPECT_NEAR(bias.mean, b, 3e-4) << b;
  }
}

/// One unknown bias takes away information in one direction only. If it counted as noise of every
/// point as well, information would be lost in all directions.
TEST(DepthLikelihood, AnUnknownBiasCountsOnce) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  const DepthPoints points = makeDepthPoints(roomDepth(), DepthParameters());
  const DepthPoints unsure = withoutBias(points, {0, 0.004 * 0.004});
  const Matrix6 lost =
      likelihood.linearize(points, kView, 0).h - likelihood.linearize(unsure, kView, 0).h;
  const Vector6 values = Eigen::SelfAdjointEigenSolver<Matrix6>(lost).eigenvalues();
  EXPECT_GT(values[5], 0);
  EXPECT_LT(values.head<5>().cwiseAbs().maxCoeff(), 1e-6 * values[5]);
}

TEST(DepthLikelihood, RefinementFindsTheTruePose) {
  Parameters params;
  params.likelihood.cues = Cues::kDepth;
  params.depth.bias_sigma = 0;
  const LocalizationMap map(test::furnishedRooms(), params);
  CameraView view;
  view.depth = map.prepareDepth(roomDepth());
  view.T_base_camera = opticalOnBody();  // the refined pose is the pose of the base
  const Pose truth = kView * view.T_base_camera.inverse();
  Random random(9);
  for (int seed = 0; seed < 50; ++seed) {
    PoseGaussian prior;
    Twist xi;
    xi << 0.1 * anywhere(&random), 0.05 * anywhere(&random);
    prior.mean = truth * expSe3(xi);
    prior.covariance.diagonal() << 1, 1, 1, 0.25, 0.25, 0.25;  // wide, so that it does not pull
    const RefinementResult result = map.refine({view}, prior.mean, prior);
    EXPECT_GT(result.matched_points, 300);
    // The depths are exact. The remaining error is the rounding of the field (0.7 mm), averaged
    // over many points.
    EXPECT_LT((result.pose.translation() - truth.translation()).norm(), 0.0005) << seed;
    EXPECT_LT(logSo3(truth.linear().transpose() * result.pose.linear()).norm(), 0.0005) << seed;
  }
}

}  // namespace
}  // namespace edge_mcl
