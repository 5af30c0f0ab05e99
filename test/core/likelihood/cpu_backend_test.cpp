#include "edge_mcl/core/likelihood/cpu_backend.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <memory>

#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/likelihood/reference_likelihood.h"
#include "edge_mcl/core/localization_map.h"
#include "support/room_view.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::posesAroundView;
using test::roomPicture;

CameraModel cameraWith(DistortionModel model) { return test::distorted(test::roomCamera(), model); }

const Pose kView = test::roomView();

struct Case {
  DistortionModel distortion;
  LikelihoodModel model;
};

class AgainstReference : public testing::TestWithParam<Case> {};

/// The kernel computes in single precision. The truth is the plain reference in double precision,
/// with the same visible set and the same table.
TEST_P(AgainstReference, EveryParticleAgrees) {
  Parameters params;
  params.likelihood.model = GetParam().model;
  const LocalizationMap map(test::furnishedRooms(), params);
  cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
  mask(cv::Rect(100, 80, 60, 50)) = 255;
  const auto image = map.prepare(cameraWith(GetParam().distortion), roomPicture(), mask, "room");
  const VisibleSet set = map.visibility().exact(kView.translation());
  const std::vector<Pose> poses = posesAroundView(400, 0.15, 0.1, 11);
  const std::vector<PoseScore> fast = evaluateWithVisibleSet(image->frame, set, poses);
  double worst = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    const PoseScore truth = referenceScore(image->frame, set, poses[i]);
    // Log-likelihoods may be zero. So below 1 nat the absolute error is used.
    const double error = std::abs(fast[i].log_likelihood - truth.log_likelihood) /
                         std::max(1.0, std::abs(truth.log_likelihood));
    worst = std::max(worst, error);
    EXPECT_NEAR(fast[i].sample_weight, truth.sample_weight, 1e-3 * (1 + truth.sample_weight));
  }
  std::printf("largest relative error of %zu particles: %.2g\n", poses.size(), worst);
  // Single precision places a sample with an error of about 2e-5 px (three roundings of 6e-8 of 300
  // px). Where the table steps from an edge to no edge, a score changes by up to 5 nats per pixel.
  // In the robust model positive and negative scores nearly cancel, so the relative error is
  // larger. The largest errors measured over these eight cases are 0.35e-5 to 1.1e-5 (paper) and
  // 2e-5 to 4e-5 (robust).
  EXPECT_LT(worst, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(
    All, AgainstReference,
    testing::Values(Case{DistortionModel::kNone, LikelihoodModel::kPaper},
                    Case{DistortionModel::kNone, LikelihoodModel::kRobust},
                    Case{DistortionModel::kPlumbBob, LikelihoodModel::kPaper},
                    Case{DistortionModel::kPlumbBob, LikelihoodModel::kRobust},
                    Case{DistortionModel::kRationalPolynomial, LikelihoodModel::kPaper},
                    Case{DistortionModel::kRationalPolynomial, LikelihoodModel::kRobust},
                    Case{DistortionModel::kEquidistant, LikelihoodModel::kPaper},
                    Case{DistortionModel::kEquidistant, LikelihoodModel::kRobust}));

/// A thinned model has fewer samples, and they are farther apart. The truth is the plain reference
/// on a visible set from which the other samples were removed by hand, with the longer step between
/// samples.
TEST(Thinning, IsAModelWithFewerSamples) {
  for (const auto model : {LikelihoodModel::kPaper, LikelihoodModel::kRobust}) {
    Parameters params;
    params.likelihood.model = model;
    const LocalizationMap map(test::furnishedRooms(), params);
    const auto image = map.prepare(cameraWith(DistortionModel::kNone), roomPicture(), {}, "room");
    const std::vector<Pose> poses = posesAroundView(50, 0.1, 0.05, 4);
    const VisibleSet all = map.visibility().exact(kView.translation());
    for (const uint32_t thinning : {1u, 3u, 8u, 30u}) {
      VisibleSet struck;
      struck.model = all.model;
      for (VisibleSet::Segment s : all.segments) {
        const EdgeSegment& segment = all.edgeSegment(s);
        for (uint32_t i = 0; i < segment.sample_count; ++i)
          if ((segment.first_sample + i) % thinning != 0) s.samples &= ~(1u << i);
        if (s.samples != 0) struck.segments.push_back(s);
      }
      LikelihoodFrame thinned = image->frame, stretched = image->frame;
      thinned.thinning = thinning;
      // In the paper's model the step has no effect.
      stretched.sample_step *= thinning;
      const std::vector<PoseScore> fast = evaluateWithVisibleSet(thinned, all, poses);
      for (size_t i = 0; i < poses.size(); ++i) {
        const PoseScore truth = referenceScore(stretched, struck, poses[i]);
        EXPECT_NEAR(fast[i].log_likelihood, truth.log_likelihood,
                    1e-4 * std::max(1.0, std::abs(truth.log_likelihood)));
        EXPECT_NEAR(fast[i].sample_weight, truth.sample_weight, 1e-3 * (1 + truth.sample_weight));
      }
    }
  }
}

/// Two vertical model lines have a vertical image edge 3 px and 4 px away. The truth is worked out
/// by hand: a sample scores g = exp(-d^2 / 2 sigma^2), a line scores the mean l of its samples, and
/// W is alpha times the exponential of k times the mean of both lines.
TEST(PaperLikelihood, HandWorkedExample) {
  CameraModel camera = test::pinhole(320, 240, 200);
  camera.fy = 200;
  camera.cx = 160;
  camera.cy = 120;
  // Lines at u = 100 and u = 220 (depth 2 m), between v = 60 and 180.
  MeshSoup soup;
  soup.vertices = {{-0.6f, -0.6f, 2}, {-0.6f, 0.6f, 2}, {0.6f, -0.6f, 2}, {0.6f, 0.6f, 2}};
  soup.lines = {{0, 1}, {2, 3}};
  Parameters params;
  params.likelihood.model = LikelihoodModel::kPaper;
  params.likelihood.sigma = 5;
  params.likelihood.k = 7;
  params.likelihood.alpha = 0.5;
  params.map.sample_step = 0.05;
  const LocalizationMap map(weldMesh(soup, 1e-6, "two lines"), params);
  // The edges are set directly. A grey step between two pixels has a gradient that is symmetric
  // about u - 0.5, and the detector would take one of the two pixels.
  EdgeImage edges;
  edges.grey = cv::Mat(240, 320, CV_8U, cv::Scalar(0));
  edges.edges = cv::Mat(240, 320, CV_8U, cv::Scalar(0));
  edges.gradient_x = cv::Mat(240, 320, CV_16S, cv::Scalar(100));
  edges.gradient_y = cv::Mat(240, 320, CV_16S, cv::Scalar(0));
  edges.edges.col(103) = 255;
  edges.edges.col(216) = 255;
  const EdgeField field(edges, EdgePixels(edges), params.image);
  LikelihoodFrame frame;
  frame.camera = camera;
  frame.table = std::make_shared<ScoreTable>(field, ScoreLevels(params.image, params.likelihood));
  frame.params = params.likelihood;
  frame.sample_step = map.edges().sample_step;
  const VisibleSet set = map.visibility().exact({0, 0, 0});
  const double l1 = std::exp(-3.0 * 3 / (2 * 25)), l2 = std::exp(-4.0 * 4 / (2 * 25));
  const double expected = std::log(0.5) + 7 * (l1 + l2) / 2;
  // The table holds scores in steps of 1/254, and k = 7 multiplies them.
  const PoseScore score = evaluateWithVisibleSet(frame, set, {Pose::Identity()}).front();
  EXPECT_NEAR(score.log_likelihood, expected, 7.0 / 254);
  EXPECT_NEAR(score.line_count, 2, 1e-5);
  EXPECT_NEAR(score.sample_weight, 48, 1e-3);
  // One line leaves the image. Only the other line counts, in the sum S and in the number m of
  // lines.
  const Pose aside = Pose(Eigen::Translation3d(1.2, 0, 0));
  edges.edges.col(103) = 0;
  const PoseScore one = evaluateWithVisibleSet(frame, set, {aside}).front();
  EXPECT_NEAR(one.line_count, 1, 1e-5);
  EXPECT_NEAR(one.log_likelihood, std::log(0.5) + 7 * l1, 7.0 / 254);
}

TEST(RobustLikelihood, WhatIsNotSeenSaysNothing) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const auto open = map.prepare(cameraWith(DistortionModel::kNone), roomPicture(), {}, "room");
  // With a mask over the whole image, or with no model line in view, the score is exactly zero.
  const cv::Mat all(240, 320, CV_8U, cv::Scalar(255));
  const auto masked = map.prepare(cameraWith(DistortionModel::kNone), roomPicture(), all, "room");
  EXPECT_EQ(map.evaluate({{masked, Pose::Identity()}}, {kView}).front().log_likelihood, 0);
  const Pose away = test::lookAlong({30, 2, 1}, {1, 0, 0});
  EXPECT_EQ(map.evaluate({{open, Pose::Identity()}}, {away}).front().log_likelihood, 0);
  EXPECT_GT(map.evaluate({{open, Pose::Identity()}}, {kView}).front().log_likelihood, 10);
}

/// The scores must be equal to the last bit.
TEST(CpuBackend, OnePoseAloneAndInABatchGiveTheSameBitsOnAnyNumberOfThreads) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const auto image = map.prepare(cameraWith(DistortionModel::kPlumbBob), roomPicture(), {}, "room");
  const std::vector<Pose> poses = posesAroundView(333, 0.2, 0.1, 13);
  std::vector<PoseScore> one_thread, two_threads;
  {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one_thread = map.evaluate({{image, Pose::Identity()}}, poses);
  }
  {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
    two_threads = map.evaluate({{image, Pose::Identity()}}, poses);
  }
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(one_thread[i].log_likelihood, two_threads[i].log_likelihood);
    if (i % 10 == 0) {
      EXPECT_EQ(map.evaluate({{image, Pose::Identity()}}, {poses[i]}).front().log_likelihood,
                one_thread[i].log_likelihood);
    }
  }
}

TEST(CpuBackend, APoseThatIsNotFiniteIsAnError) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const auto image = map.prepare(cameraWith(DistortionModel::kNone), roomPicture(), {}, "room");
  Pose bad = kView;
  bad.translation().x() = NAN;
  EXPECT_THROW(map.evaluate({{image, Pose::Identity()}}, {bad}), std::exception);
  EXPECT_THROW(map.prepare(test::pinhole(640, 480), roomPicture(), {}, "room"), std::exception);
}

}  // namespace
}  // namespace edge_mcl
