#include "edge_mcl/localization/filter/pose_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/filter/resampling.h"
#include "support/error_text.h"
#include "support/map_views.h"

namespace edge_mcl {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

FilterParameters manyParticles() {
  FilterParameters params;
  params.particles = 5000;
  return params;
}

PoseFilter filterOf(const FilterParameters& params, bool refine = true) {
  RefinementParameters refinement;
  refinement.enabled = refine;
  return {params, refinement};
}

Pose at(double x) { return Pose(Eigen::Translation3d(x, 0, 0)); }

const PoseGaussian kStart{
    expSe3((Twist() << 1, 2, 1.5, 0.1, -0.2, 0.7).finished()),
    (Twist() << 0.01, 0.04, 0.0025, 0.001, 0.002, 0.004).finished().asDiagonal()};

/// Compares the particles, taken as equally heavy, with a Gaussian.
void expectCloud(const std::vector<Pose>& poses, const PoseGaussian& expected) {
  const auto n = static_cast<double>(poses.size());
  const PoseGaussian cloud = meanAndCovariance(poses, std::vector<double>(poses.size(), 1));
  const Twist shift = logSe3(expected.mean.inverse() * cloud.mean);
  for (int i = 0; i < 6; ++i) {
    // The mean of n draws has an error of sigma / sqrt(n), and the variance an error of sqrt(2 / n)
    // of itself. Five of these are allowed.
    const double variance = expected.covariance(i, i);
    EXPECT_NEAR(shift[i], 0, 5 * std::sqrt(variance / n)) << "axis " << i;
    EXPECT_NEAR(cloud.covariance(i, i), variance, 5 * std::sqrt(2 / n) * variance) << "axis " << i;
  }
}

TEST(PoseFilter, StartsWithParticlesFromTheGaussian) {
  PoseFilter filter = filterOf(manyParticles());
  filter.initialize(kStart);
  ASSERT_EQ(filter.poses().size(), 5000u);
  EXPECT_EQ(filter.logWeights(), std::vector<double>(5000, 0));
  EXPECT_EQ(filter.estimate().mean.matrix(), kStart.mean.matrix());
  EXPECT_EQ(filter.estimate().covariance, kStart.covariance);
  expectCloud(filter.poses(), kStart);
}

TEST(PoseFilter, StartsWithIndependentNoisePerAxis) {
  PoseFilter filter = filterOf(manyParticles());
  filter.initialize(kStart.mean, 0.2, 0.05);
  PoseGaussian expected{kStart.mean, Matrix6::Zero()};
  expected.covariance.diagonal() << 0.04, 0.04, 0.04, 0.0025, 0.0025, 0.0025;
  EXPECT_TRUE(filter.estimate().covariance.isApprox(expected.covariance, 1e-12));
  expectCloud(filter.poses(), expected);
}

TEST(PoseFilter, TheSeedDecidesTheParticles) {
  const auto firstOf = [](uint64_t seed) {
    FilterParameters params;
    params.seed = seed;
    PoseFilter filter = filterOf(params);
    filter.initialize(kStart);
    return filter.poses().front().matrix();
  };
  EXPECT_EQ(firstOf(3), firstOf(3));
  EXPECT_NE(firstOf(3), firstOf(4));
}

TEST(PoseFilter, AStartThatIsNotFiniteIsAnError) {
  PoseFilter filter = filterOf({});
  PoseGaussian start;
  start.mean.translation().y() = kNaN;
  test::expectError<InputError>("not finite", [&] { filter.initialize(start); });
  start = {};
  start.covariance(2, 2) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(filter.initialize(start), InputError);
  EXPECT_THROW(filter.initialize(Pose::Identity(), kNaN, 0.1), InputError);
}

/// The weights are 1/4 and 3/4, so the mean is at 0.75 m and the variance is 3/16 m^2.
TEST(PoseFilter, GivenParticlesGiveTheEstimate) {
  PoseFilter filter = filterOf({});
  filter.setParticles({at(0), at(1)}, {-700, -700 + std::log(3)});
  ASSERT_EQ(filter.poses().size(), 2u);
  EXPECT_NEAR(filter.estimate().mean.translation().x(), 0.75, 1e-9);
  EXPECT_NEAR(filter.estimate().covariance(0, 0), 3.0 / 16, 1e-9);
}

TEST(PoseFilter, GivenParticlesThatCannotBeUsedAreErrors) {
  PoseFilter filter = filterOf({});
  EXPECT_THROW(filter.setParticles({}, {}), Error);
  EXPECT_THROW(filter.setParticles({at(0), at(1)}, {0}), Error);
  test::expectError<InputError>("particle 1", [&] {
    filter.setParticles({at(0), at(kNaN)}, {0, 0});
  });
  test::expectError<InputError>("particle 0", [&] {
    filter.setParticles({at(0), at(1)}, {kNaN, 0});
  });
}

/// Systematic resampling makes 300 and 700 copies, or one more or less.
TEST(PoseFilter, ResamplingMakesEqualWeights) {
  FilterParameters params;
  params.particles = 1000;
  PoseFilter filter = filterOf(params);
  filter.setParticles({at(0), at(1), at(2)}, {std::log(0.3), -1e9, std::log(0.7)});
  filter.resample();
  ASSERT_EQ(filter.poses().size(), 1000u);
  EXPECT_EQ(filter.logWeights(), std::vector<double>(1000, 0));
  int first = 0;
  for (const Pose& pose : filter.poses()) {
    EXPECT_NE(pose.translation().x(), 1);
    first += pose.translation().x() == 0 ? 1 : 0;
  }
  EXPECT_NEAR(first, 300, 1);
}

/// Without refinement, particles are resampled only when the effective sample size is small.
TEST(PoseFilter, WithoutRefinementEvenWeightsAreKept) {
  FilterParameters params;
  params.particles = 4;
  params.resample_threshold = 0.5;
  PoseFilter filter = filterOf(params, false);
  const std::vector<double> even{0, 0.1, 0, 0};
  filter.setParticles({at(0), at(1), at(2), at(3)}, even);
  filter.resample();
  EXPECT_EQ(filter.logWeights(), even);
  filter.setParticles({at(0), at(1), at(2), at(3)}, {0, 9, 0, 0});
  filter.resample();
  EXPECT_EQ(filter.logWeights(), std::vector<double>(4, 0));
  for (const Pose& pose : filter.poses()) EXPECT_EQ(pose.translation().x(), 1);
}

TEST(PoseFilter, OdometryWithoutNoiseMovesEveryParticleByTheIncrement) {
  FilterParameters params;
  params.odometry_noise_position = params.odometry_noise_angle_deg =
      params.odometry_noise_per_metre = params.odometry_noise_per_radian = 0;
  PoseFilter filter = filterOf(params);
  filter.initialize(kStart);
  const std::vector<Pose> before = filter.poses();
  const Pose step = expSe3((Twist() << 0.3, -0.1, 0.05, 0.02, 0.03, -0.2).finished());
  filter.predictWithOdometry(step, 0.1);
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_TRUE(filter.poses()[i].isApprox(before[i] * step, 1e-12));
  EXPECT_TRUE(filter.estimate().mean.isApprox(kStart.mean * step, 1e-12));
}

/// The truth is moved(), which is tested by itself.
TEST(PoseFilter, OdometryNoiseWidensParticlesAndEstimate) {
  const FilterParameters params = manyParticles();
  PoseFilter filter = filterOf(params);
  filter.initialize(kStart);
  PoseGaussian expected = kStart;
  const Pose step = expSe3((Twist() << 0.2, 0, 0.05, 0, 0.03, -0.1).finished());
  for (int i = 0; i < 3; ++i) {
    filter.predictWithOdometry(step, 0.2);
    expected = moved(expected, step, odometryNoise(params, step, 0.2));
  }
  EXPECT_TRUE(filter.estimate().mean.isApprox(expected.mean, 1e-12));
  EXPECT_TRUE(filter.estimate().covariance.isApprox(expected.covariance, 1e-9));
  expectCloud(filter.poses(), expected);
}

/// No image has given a velocity, so the mean stays.
TEST(PoseFilter, WithoutOdometryAndVelocityTheParticlesSpreadInPlace) {
  const FilterParameters params = manyParticles();
  PoseFilter filter = filterOf(params);
  filter.initialize(kStart);
  filter.predictWithoutOdometry(0.5);
  PoseGaussian expected = moved(kStart, Pose::Identity(), walkNoise(params, 0.5));
  const double distance = 0.5 * 5 * (1 - std::exp(-0.5 / 5));  // 0.5 m/s, forgotten over 5 s
  expected.covariance.diagonal().array() += distance * distance;
  EXPECT_TRUE(filter.estimate().mean.isApprox(kStart.mean, 1e-12));
  EXPECT_TRUE(filter.estimate().covariance.isApprox(expected.covariance, 1e-9));
  expectCloud(filter.poses(), expected);
}

TEST(PoseFilter, AMotionThatIsNotFiniteIsAnError) {
  PoseFilter filter = filterOf({});
  filter.initialize(kStart);
  EXPECT_THROW(filter.predictWithOdometry(at(kNaN), 0.1), InputError);
  EXPECT_THROW(filter.predictWithOdometry(at(0), -0.1), InputError);
  EXPECT_THROW(filter.predictWithOdometry(at(0), kNaN), InputError);
  EXPECT_THROW(filter.predictWithoutOdometry(-0.1), InputError);
  EXPECT_THROW(filter.predictWithoutOdometry(kNaN), InputError);
  EXPECT_EQ(filter.estimate().mean.matrix(), kStart.mean.matrix());
}

/// The truth is correctTilt() of a Gaussian, which is tested by itself.
TEST(PoseFilter, AReadingOfRollAndPitchCorrectsTheEstimate) {
  PoseFilter filter = filterOf(manyParticles());
  filter.initialize(kStart);
  const Eigen::Vector3d up = kStart.mean.linear().transpose() * Eigen::Vector3d::UnitZ();
  const UpReading reading{expSo3(Eigen::Vector3d(0.02, 0.03, 0)) * up, 0.01};
  const PoseGaussian expected = correctTilt(reading, kStart);
  ASSERT_TRUE(filter.correctTilt(reading));
  EXPECT_TRUE(filter.estimate().mean.isApprox(expected.mean, 1e-12));
  EXPECT_TRUE(filter.estimate().covariance.isApprox(expected.covariance, 1e-9));
  // The particles turn about horizontal axes only, so their mean agrees in roll and pitch.
  const Pose cloud = meanAndCovariance(filter.poses(), std::vector<double>(5000, 1)).mean;
  const Eigen::Vector3d difference =
      (cloud.linear() - expected.mean.linear()).transpose() * Eigen::Vector3d::UnitZ();
  // The mean of 5000 particles of 0.04 rad has an error of 0.6 mrad. Curvature adds the square of
  // 0.04 rad, 1.6 mrad.
  EXPECT_LT(difference.norm(), 0.004);
}

TEST(PoseFilter, AReadingThatContradictsTheParticlesIsLeftOut) {
  PoseFilter filter = filterOf({});
  filter.initialize(kStart);
  const std::vector<Pose> before = filter.poses();
  // The reading lies on its side, more than thirty standard deviations away.
  EXPECT_FALSE(filter.correctTilt({Eigen::Vector3d::UnitX(), 0.01}));
  for (size_t i = 0; i < before.size(); ++i)
    EXPECT_EQ(filter.poses()[i].matrix(), before[i].matrix());
  EXPECT_EQ(filter.estimate().mean.matrix(), kStart.mean.matrix());
}

TEST(PoseFilter, AReadingThatIsNoDirectionIsAnError) {
  PoseFilter filter{FilterParameters(), RefinementParameters()};
  filter.initialize(kStart);
  EXPECT_THROW(filter.correctTilt({{NAN, 0, 1}, 0.02}), InputError);
  EXPECT_THROW(filter.correctTilt({{0, 0, 0.4}, 0.02}), InputError);
  EXPECT_THROW(filter.correctTilt({{0, 0, 1}, 0}), InputError);
  EXPECT_THROW(filter.correctTilt({{0, 0, 1}, kNaN}), InputError);
}

/// The camera stands in the furnished rooms. The base is the camera.
class PoseFilterInRoom : public testing::Test {
 protected:
  const LocalizationMap map_{test::furnishedRooms(), Parameters()};
  const Pose truth_ = test::roomView();

  /// A filter with 300 particles.
  PoseFilter begun(double position, double angle, bool refine = true) const {
    FilterParameters params;
    params.particles = 300;
    PoseFilter filter = filterOf(params, refine);
    const Twist error = (Twist() << 0.03, -0.02, 0.04, 0.01, -0.01, 0.02).finished();
    filter.initialize(truth_ * expSe3(error), position, angle);
    return filter;
  }
};

/// The truth is the pose of the rendered image.
TEST_F(PoseFilterInRoom, AnUpdateFindsTheTruePose) {
  PoseFilter filter = begun(0.05, 0.02);
  const CameraView view = test::viewInRoom(map_);
  const UpdateReport report = filter.update(map_, {view});
  const PoseGaussian& estimate = filter.estimate();
  // The start has an error of 5 cm. The refinement is good to some millimetres in this room.
  EXPECT_LT((estimate.mean.translation() - truth_.translation()).norm(), 0.02);
  EXPECT_LT(rotationAngle(estimate.mean, truth_), 0.4 * M_PI / 180);
  EXPECT_TRUE(report.has_information);
  EXPECT_GE(report.refined_modes, 1);
  EXPECT_TRUE(report.tempering > 0 && report.tempering <= 1 + 1e-9) << report.tempering;
  EXPECT_LE(report.matched_samples, report.used_samples);
  EXPECT_GT(report.matched_samples, report.used_samples / 2);
  EXPECT_EQ(report.depth_points, 0);
  EXPECT_EQ(report.injected_share, 0);
  // The figures of the estimate are the map's figures at this pose.
  const PoseScore score = map_.evaluate({view}, {estimate.mean}).front();
  EXPECT_EQ(report.log_likelihood, score.log_likelihood);
  EXPECT_EQ(report.visible_samples, score.sample_weight);
  EXPECT_EQ(report.evidence_per_line, score.scorePerLine());
}

/// Without refinement the particles stay, and every weight is the tempered likelihood. The truth is
/// the map's score of the same particles.
TEST_F(PoseFilterInRoom, WeightsAreTheTemperedLikelihood) {
  FilterParameters params;
  params.particles = 300;
  params.max_passes = 1;
  PoseFilter filter = filterOf(params, false);
  filter.initialize(truth_, 0.05, 0.02);
  const std::vector<Pose> before = filter.poses();
  CameraView view = test::viewInRoom(map_);
  const UpdateReport report = filter.update(map_, {view});
  view.thinning =
      map_.thinningFor(view, truth_, static_cast<size_t>(map_.params().likelihood.max_samples));
  const std::vector<PoseScore> scores = map_.evaluate({view}, before);
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(filter.poses()[i].matrix(), before[i].matrix());
    const double expected =
        report.tempering * (scores[i].log_likelihood - scores[0].log_likelihood);
    EXPECT_NEAR(filter.logWeights()[i] - filter.logWeights()[0], expected, 1e-9);
  }
  EXPECT_NEAR(report.effective_sample_size, effectiveSampleSize(normalize(filter.logWeights())),
              1e-9);
  // The weights were tempered to this share of the particles, or not at all.
  EXPECT_GE(report.effective_sample_size, params.ess_floor * 300 - 1e-6);
  EXPECT_EQ(report.passes, 1);
}

TEST_F(PoseFilterInRoom, OnlyAWideSpreadTakesSeveralPasses) {
  const CameraView view = test::viewInRoom(map_);
  PoseFilter narrow = begun(0.01, 0.005), wide = begun(0.4, 0.15);
  EXPECT_EQ(narrow.update(map_, {view}).passes, 1);
  const UpdateReport report = wide.update(map_, {view});
  EXPECT_GT(report.passes, 1);
  EXPECT_LE(report.passes, FilterParameters().max_passes);
  EXPECT_LE(report.tempering, 1 + 1e-9);
}

/// The camera is outside of the building and looks away from it.
TEST_F(PoseFilterInRoom, WithoutTheModelInViewThePoseIsThePrediction) {
  FilterParameters params;
  params.particles = 300;
  PoseFilter filter = filterOf(params);
  const Pose away = test::lookAlong({-5, 2, 1}, {-1, 0, 0});
  filter.initialize(away, 0.02, 0.01);
  filter.predictWithOdometry(Pose::Identity(), 0.1);
  const UpdateReport report = filter.update(map_, {test::viewInRoom(map_)});
  EXPECT_FALSE(report.has_information);
  EXPECT_EQ(report.visible_samples, 0);
  EXPECT_EQ(report.log_likelihood, 0);
  // The mean of 300 particles of 3 cm has an error of 2 mm. Four of these are allowed.
  EXPECT_LT((filter.estimate().mean.translation() - away.translation()).norm(), 0.008);
}

/// Two runs with one seed must give equal bits, however many threads share the work.
TEST_F(PoseFilterInRoom, IsReproducible) {
  const CameraView view = test::viewInRoom(map_);
  PoseFilter first = begun(0.3, 0.1), second = begun(0.3, 0.1);
  for (PoseFilter* filter : {&first, &second})
    for (int i = 0; i < 2; ++i) {
      filter->predictWithoutOdometry(0.1);
      filter->update(map_, {view});
    }
  EXPECT_EQ(first.estimate().mean.matrix(), second.estimate().mean.matrix());
  EXPECT_EQ(first.estimate().covariance, second.estimate().covariance);
  EXPECT_EQ(first.logWeights(), second.logWeights());
}

/// The camera moves 0.25 m during a gap of 10 s, so its velocity is 2.5 cm/s.
TEST_F(PoseFilterInRoom, OverAGapTheVelocityIsThatOfAllItsTime) {
  FilterParameters params = map_.params().filter;
  params.particles = 1000;         // fewer may miss the pose at the first image after the gap
  params.walk_acceleration = 0.1;  // with the default no more than a tenth counts as velocity
  PoseFilter filter(params, map_.params().refinement);
  filter.initialize(truth_, 0.02, 0.01);
  const Pose moved = truth_ * expSe3((Twist() << 0.25, 0, 0, 0, 0, 0).finished());
  filter.predictWithoutOdometry(0.1);
  filter.update(map_, {test::viewInRoom(map_)});
  filter.predictWithoutOdometry(1, 10);  // the gap lasts 10 s, the filter predicts at most 1 s
  for (int i = 0; i < 2; ++i) filter.update(map_, {test::viewInRoom(map_, moved)});
  ASSERT_LT((filter.estimate().mean.translation() - moved.translation()).norm(), 0.03);
  filter.predictWithoutOdometry(1);
  // At 2.5 cm/s it moves on by 2.5 cm. If the gap counted as 1 s, it would move by 20 cm.
  EXPECT_LT((filter.estimate().mean.translation() - moved.translation()).norm(), 0.1);
}

/// The depth camera reads z - b z^2 instead of z. The filter must learn b.
TEST(PoseFilterWithDepth, TheBiasOfTheSensorIsLearnt) {
  const LocalizationMap map(test::furnishedRooms(), test::depthAlone());
  constexpr double kBias = 0.003;  // 1/m; 1.5 standard deviations of the prior
  DepthImage image;
  image.camera = test::pinhole(160, 120, 110);
  image.depth = test::renderDepth(test::furnishedRooms(), image.camera, test::roomView());
  cv::Mat square = image.depth.mul(image.depth);
  image.depth -= kBias * square;
  const CameraView view{nullptr, Pose::Identity(), 1, map.prepareDepth(image)};
  FilterParameters params;
  params.particles = 300;
  PoseFilter filter = filterOf(params);
  filter.initialize(test::roomView(), 0.02, 0.01);
  UpdateReport report;
  double first = 0;
  for (int i = 0; i < 50; ++i) {
    filter.predictWithOdometry(Pose::Identity(), 0.1);
    report = filter.update(map, {view});
    if (i == 0) first = report.depth_bias;
  }
  EXPECT_GT(report.depth_points, 100);
  EXPECT_GT(report.depth_agreement, 0.9);
  // At first the pose takes up most of the bias. Every image moves a part of it to the sensor, and
  // after fifty images about a sixth is left.
  EXPECT_LT(std::abs(report.depth_bias - kBias), std::abs(first - kBias));
  EXPECT_NEAR(report.depth_bias, kBias, 0.25 * kBias);
  // A bias that was learnt at an old pose does not count at a new one.
  filter.initialize(test::roomView(), 0.02, 0.01);
  EXPECT_LT(std::abs(filter.update(map, {test::depthInRoom(map)}).depth_bias), 0.3 * kBias);
}

/// The camera moves farther than its odometry says, as if it was pushed. @param share largest share
/// of injected particles @return for how many of 20 seeds the filter finds the camera again, within
/// 5 cm
int recovered(const LocalizationMap& map, const FilterParameters& usual, double* share) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  const Pose before = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});
  const Pose after = before * expSe3((Twist() << 0.35, -0.1, 0.25, 0.05, 0.2, -0.04).finished());
  const auto viewFrom = [&](const Pose& pose) {
    const cv::Mat image = test::render(test::furnishedRooms(), camera, pose, 1);
    return CameraView{map.prepare(camera, image, {}, "test"), Pose::Identity(), 1, nullptr};
  };
  const CameraView first = viewFrom(before), second = viewFrom(after);
  int count = 0;
  *share = 0;
  constexpr int kSeeds = 20;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    FilterParameters params = usual;
    params.seed = static_cast<uint64_t>(seed);
    params.particles = 300;
    PoseFilter filter(params, map.params().refinement);
    filter.initialize(before, 0.02, 0.01);
    for (int i = 0; i < 40; ++i) {
      filter.predictWithOdometry(Pose::Identity(), 0.1);
      const UpdateReport report = filter.update(map, {i < 20 ? first : second});
      if (i < 20) {
        EXPECT_LT(report.injected_share, 0.3);
      }
      *share = std::max(*share, report.injected_share);
    }
    const Pose error = filter.estimate().mean.inverse() * after;
    if (error.translation().norm() < 0.05) ++count;
  }
  return count;
}

/// The same flights are run without and with injected particles.
TEST(Recovery, ACameraThatWasPushedIsFoundAgain) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  FilterParameters params;
  double share = 0;
  const int without = recovered(map, params, &share);
  EXPECT_EQ(share, 0);
  params.recovery_alpha_slow = 0.02;
  params.recovery_alpha_fast = 0.3;
  const int with = recovered(map, params, &share);
  EXPECT_GT(share, 0.1);
  EXPECT_GE(with, 14);
  EXPECT_LE(without, 4);
}

}  // namespace
}  // namespace edge_mcl
