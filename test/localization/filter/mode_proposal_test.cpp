#include "edge_mcl/localization/filter/mode_proposal.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "support/map_views.h"

namespace edge_mcl {
namespace {

const Pose kMean = expSe3((Twist() << 1, -2, 3, 0.4, -0.3, 0.9).finished());

Matrix6 randomCovariance(RandomSource* random, double scale) {
  Matrix6 root;
  for (int i = 0; i < 6; ++i) root.col(i) = scale * random->normalTwist();
  return root * root.transpose();
}

/// Log of the normal density of six dimensions, written out. Independent of Cholesky factors.
double plainLog(const Matrix6& covariance, const Twist& offset) {
  return -0.5 * (6 * std::log(2 * M_PI) + std::log(covariance.determinant()) +
                 offset.dot(covariance.inverse() * offset));
}

TEST(GaussianDensity, AgreesWithTheFormulaOfTheNormalDensity) {
  RandomSource random(51);
  for (int i = 0; i < 20; ++i) {
    const PoseGaussian gaussian{kMean, randomCovariance(&random, 0.1)};
    const GaussianDensity density(gaussian);
    EXPECT_EQ(density.gaussian().mean.matrix(), kMean.matrix());
    const Matrix6& covariance = density.gaussian().covariance;
    const Twist offset = 0.2 * random.normalTwist();
    const double expected = plainLog(covariance, offset);
    // The plain inverse of a matrix with a condition of 1e4 to 1e6 costs some digits.
    EXPECT_NEAR(density.logOfOffset(offset), expected, 1e-7 * (1 + std::abs(expected)));
    EXPECT_NEAR(density.log(kMean * expSe3(offset)), expected, 1e-7 * (1 + std::abs(expected)));
    EXPECT_LT((density.offset(kMean * expSe3(offset)) - offset).norm(), 1e-9);
  }
}

/// The header says how much is added to the variances. 0.003 degrees are rounded to one digit.
TEST(GaussianDensity, WithoutCovarianceItIsNarrowAndStillADensity) {
  const GaussianDensity density({kMean, Matrix6::Zero()});
  const Twist variance = density.gaussian().covariance.diagonal();
  EXPECT_TRUE(density.gaussian().covariance.isDiagonal());
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::sqrt(variance[i]), 1e-4, 1e-9);
  for (int i = 3; i < 6; ++i) EXPECT_NEAR(std::sqrt(variance[i]) * 180 / M_PI, 0.003, 0.0005);
  EXPECT_NEAR(density.log(kMean), plainLog(density.gaussian().covariance, Twist::Zero()), 1e-9);
  RandomSource random(52);
  for (int i = 0; i < 100; ++i) {
    const Twist offset = density.offset(density.draw(&random));
    EXPECT_LT(offset.cwiseQuotient(variance.cwiseSqrt()).cwiseAbs().maxCoeff(), 5);
  }
}

TEST(GaussianDensity, DrawsHaveItsMeanAndItsCovariance) {
  RandomSource random(53);
  const GaussianDensity density({kMean, randomCovariance(&random, 0.02)});
  constexpr int kDraws = 20000;
  std::vector<Pose> poses;
  poses.reserve(kDraws);
  for (int i = 0; i < kDraws; ++i) poses.push_back(density.draw(&random));
  for (const Pose& pose : poses) ASSERT_TRUE(isValid(pose));
  const PoseGaussian drawn = meanAndCovariance(poses, std::vector<double>(kDraws, 1));
  const Matrix6& expected = density.gaussian().covariance;
  for (int i = 0; i < 6; ++i) {
    const double sigma = std::sqrt(expected(i, i));
    // The mean of 20000 draws has an error of 1/141 of the standard deviation. Five are allowed.
    EXPECT_NEAR(density.offset(drawn.mean)[i], 0, 5.0 / 141 * sigma);
    for (int j = 0; j < 6; ++j)
      // The error of a sample covariance is at most sqrt(2)/141 of the product of both deviations.
      EXPECT_NEAR(drawn.covariance(i, j), expected(i, j),
                  5 * 1.42 / 141 * sigma * std::sqrt(expected(j, j)));
  }
}

class PredictiveDensityTest : public testing::Test {
 protected:
  static constexpr double kShare = 0.2;
  RandomSource random_{54};
  const PoseGaussian cloud_{kMean, randomCovariance(&random_, 0.03)};
  const Matrix6 extra_ = 0.01 * Matrix6::Identity();
  const PredictiveDensity density_{cloud_, kShare, extra_};
};

TEST_F(PredictiveDensityTest, IsTheMixtureOfCoreAndTail) {
  const GaussianDensity core(cloud_), tail({kMean, cloud_.covariance + extra_});
  EXPECT_EQ(density_.core().covariance, core.gaussian().covariance);
  for (int i = 0; i < 50; ++i) {
    const Pose pose = kMean * expSe3(0.05 * random_.normalTwist());
    const double plain =
        std::log((1 - kShare) * std::exp(core.log(pose)) + kShare * std::exp(tail.log(pose)));
    EXPECT_NEAR(density_.log(pose), plain, 1e-9 * (1 + std::abs(plain)));
  }
}

/// The densities of a far pose are too small for a double, but their logarithms are not.
TEST_F(PredictiveDensityTest, FarAwayOnlyTheTailCounts) {
  const GaussianDensity tail({kMean, cloud_.covariance + extra_});
  const Pose far = kMean * expSe3((Twist() << 50, 0, 0, 0, 0, 1).finished());
  EXPECT_LT(tail.log(far), -1000);
  EXPECT_NEAR(density_.log(far), std::log(kShare) + tail.log(far), 1e-9 * -tail.log(far));
}

TEST_F(PredictiveDensityTest, WithoutATailItIsTheCore) {
  const PredictiveDensity density(cloud_, 0, extra_);
  const GaussianDensity core(cloud_);
  for (int i = 0; i < 20; ++i) {
    const Pose pose = kMean * expSe3(random_.normalTwist());
    EXPECT_NEAR(density.log(pose), core.log(pose), 1e-12 * std::abs(core.log(pose)));
    EXPECT_EQ(density.componentOf(pose).covariance, core.gaussian().covariance);
  }
}

TEST_F(PredictiveDensityTest, TheComponentIsTheLikelierOne) {
  const GaussianDensity core(cloud_), tail({kMean, cloud_.covariance + extra_});
  EXPECT_EQ(density_.componentOf(kMean).covariance, core.gaussian().covariance);
  int tails = 0;
  for (int i = 0; i < 100; ++i) {
    const Pose pose = kMean * expSe3(0.06 * random_.normalTwist());
    const bool is_tail =
        kShare * std::exp(tail.log(pose)) > (1 - kShare) * std::exp(core.log(pose));
    tails += is_tail ? 1 : 0;
    EXPECT_EQ(density_.componentOf(pose).covariance,
              is_tail ? tail.gaussian().covariance : core.gaussian().covariance);
  }
  EXPECT_GT(tails, 10);
  EXPECT_LT(tails, 100);
}

TEST_F(PredictiveDensityTest, TailsAreDrawnFromTheWiderGaussian) {
  constexpr int kDraws = 5000;
  std::vector<Pose> poses;
  poses.reserve(kDraws);
  for (int i = 0; i < kDraws; ++i) poses.push_back(density_.drawTail(&random_));
  const Matrix6 drawn = meanAndCovariance(poses, std::vector<double>(kDraws, 1)).covariance;
  const Matrix6 expected = cloud_.covariance + extra_;
  // A sample variance of 5000 draws has an error of 2 %. The rotations of 0.1 rad curve the space,
  // which changes variances by about their size, 1 %.
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(drawn(i, i), expected(i, i), 0.12 * expected(i, i));
}

/// The camera stands in the furnished rooms. The particles are drawn around its true pose.
class ModeProposalTest : public testing::Test {
 protected:
  static constexpr int kStarts = 6;
  const LocalizationMap map_{test::furnishedRooms(), Parameters()};
  const Pose truth_ = test::roomView();

  /// The modes from 100 particles. @param position, angle their standard deviations, m and rad.
  ModeProposal propose(const CameraView& view, int starts, double position, double angle) const {
    RandomSource random(55);
    PoseGaussian around{
        truth_ * expSe3((Twist() << 0.03, -0.02, 0.02, 0.01, -0.01, 0.02).finished()),
        Matrix6::Zero()};
    around.covariance.diagonal().head<3>().setConstant(position * position);
    around.covariance.diagonal().tail<3>().setConstant(angle * angle);
    const GaussianDensity density(around);
    std::vector<Pose> predicted;
    predicted.reserve(100);
    for (int i = 0; i < 100; ++i) predicted.push_back(density.draw(&random));
    const PoseGaussian cloud = meanAndCovariance(predicted, std::vector<double>(100, 1));
    return {map_,  {view}, predicted, map_.evaluate({view}, predicted), {cloud, 0, Matrix6::Zero()},
            starts};
  }
};

/// The truth is the pose of the rendered image.
TEST_F(ModeProposalTest, AModeLiesAtTheTruePose) {
  const ModeProposal modes = propose(test::viewInRoom(map_), kStarts, 0.05, 0.02);
  ASSERT_FALSE(modes.empty());
  EXPECT_LE(modes.size(), static_cast<size_t>(kStarts));
  const Pose& best = modes.mode(0).gaussian().mean;
  // Particles have an error of 9 cm. The refinement is good to some millimetres in this room.
  EXPECT_LT((best.translation() - truth_.translation()).norm(), 0.02);
  EXPECT_LT(rotationAngle(best, truth_), 0.4 * M_PI / 180);
}

/// At poses near the modes, the truth is the mean of the densities of all modes.
void expectMeanOfModes(const ModeProposal& modes, RandomSource* random) {
  for (size_t k = 0; k < modes.size(); ++k) {
    const Pose pose = modes.mode(k).draw(random);
    double sum = 0;
    for (size_t i = 0; i < modes.size(); ++i) sum += std::exp(modes.mode(i).log(pose));
    EXPECT_NEAR(modes.log(pose), std::log(sum / static_cast<double>(modes.size())), 1e-9);
  }
}

/// A long fence of equal slats. Its image does not change when the camera moves on by one slat. The
/// particles lie between two look-alikes, so both must become modes.
TEST(ModeProposal, LookAlikesAreModesOfTheirOwn) {
  constexpr float kDistance = 0.5f;  // of the slats, m
  MeshSoup soup;
  for (int i = -30; i <= 30; ++i) {
    const float x = kDistance * static_cast<float>(i);
    test::addBox(&soup, {x, 2.5f, 0}, {x + 0.15f, 2.6f, 1});
  }
  const MeshModel fence = weldMesh(std::move(soup), 1e-6, "fence");
  const LocalizationMap map(fence, Parameters());
  const Pose truth = test::lookAlong({0, 0, 0.6}, {0, 1, -0.05});
  const CameraModel camera = test::roomCamera();
  const CameraView view{map.prepare(camera, test::render(fence, camera, truth, 1), {}, "fence"),
                        Pose::Identity(), 1, nullptr};

  const auto shifted = [&](double x) { return Pose(Eigen::Translation3d(x, 0, 0) * truth); };
  PoseGaussian cloud{shifted(0.5 * kDistance), 1e-4 * Matrix6::Identity()};
  cloud.covariance(0, 0) = 0.04;  // m^2; the x axis of the camera runs along the fence
  RandomSource random(57);
  const GaussianDensity density(cloud);
  std::vector<Pose> predicted;
  predicted.reserve(100);
  for (int i = 0; i < 100; ++i) predicted.push_back(density.draw(&random));
  const ModeProposal modes(map, {view}, predicted, map.evaluate({view}, predicted),
                           {cloud, 0, Matrix6::Zero()}, 20);
  ASSERT_GE(modes.size(), 2u);
  EXPECT_LE(modes.size(), 20u);
  bool here = false, beside = false;
  for (size_t i = 0; i < modes.size(); ++i) {
    const Eigen::Vector3d at = modes.mode(i).gaussian().mean.translation();
    here |= (at - truth.translation()).norm() < 0.02;
    beside |= (at - shifted(kDistance).translation()).norm() < 0.02;
  }
  EXPECT_TRUE(here);
  EXPECT_TRUE(beside);
  for (size_t a = 0; a < modes.size(); ++a)
    for (size_t b = a + 1; b < modes.size(); ++b) {
      const Twist offset = modes.mode(a).offset(modes.mode(b).gaussian().mean);
      const Matrix6 inverse = modes.mode(a).gaussian().covariance.inverse();
      // Two modes differ by a standard deviation per axis, root mean square over the six axes.
      EXPECT_GT(offset.dot(inverse * offset), 6) << a << " " << b;
    }
  expectMeanOfModes(modes, &random);
  // Far from every mode the densities are too small for a double, but their logarithms are not.
  const double far = modes.log(truth * expSe3(10 * Twist::Ones()));
  EXPECT_LT(far, -1000);
  EXPECT_TRUE(std::isfinite(far));
}

TEST_F(ModeProposalTest, OneStartGivesOneModeAtMost) {
  EXPECT_EQ(propose(test::viewInRoom(map_), 1, 0.05, 0.02).size(), 1u);
}

/// A refinement without six matched samples is no mode.
TEST_F(ModeProposalTest, AnImageWithoutEdgesHasNoMode) {
  const ModeProposal modes = propose(test::darkView(map_), kStarts, 0.05, 0.02);
  EXPECT_TRUE(modes.empty());
  EXPECT_EQ(modes.size(), 0u);
}

}  // namespace
}  // namespace edge_mcl
