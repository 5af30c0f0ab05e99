#include "edge_mcl/localization/filter/estimate_covariance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

/// A building without images: lines with known rows of the Jacobian and a constant offset each.
/// Poses are small, so the space is flat and a linear filter is exact.
class ManyLines {
 public:
  ManyLines(uint64_t seed, size_t lines, double sigma) : random_(seed) {
    for (size_t l = 0; l < lines; ++l) {
      rows_.push_back(300 * random_.normalTwist());  // pixels per metre and radian
      offsets_.push_back(sigma * random_.normal());
    }
  }

  struct Run {
    Twist error;
    PoseGaussian estimate;
    double line_sigma;
  };

  /// Follows a pose at rest. Every step adds motion noise and an update.
  Run follow(int steps, double motion_sigma, const Eigen::Vector3d& calibration_error) {
    EstimateCovariance covariance;
    const Matrix6 start = 1e-6 * Matrix6::Identity();
    covariance.reset(start);
    Twist error = 1e-3 * random_.normalTwist();  // of the estimate
    Matrix6 prior = start;
    for (int k = 0; k < steps; ++k) {
      const Vector6 noise = Vector6::Constant(motion_sigma * motion_sigma);
      error += motion_sigma * random_.normalTwist();
      covariance.move(Pose::Identity(), noise);
      prior.diagonal() += noise;
      Matrix6 information = Matrix6::Zero();
      Twist pull = Twist::Zero();
      for (size_t l = 0; l < rows_.size(); ++l) {
        information += rows_[l] * rows_[l].transpose();
        pull += rows_[l] * (offsets_[l] + row(l).dot(calibration_error));
      }
      // x = A x' + P sum p_l b_l
      const Matrix6 posterior = inverseOf(inverseOf(prior) + information);
      error = posterior * (inverseOf(prior) * error + pull);
      covariance.correct(observe(error, calibration_error), prior);
      prior = posterior;
    }
    return {error, {Pose::Identity(), covariance.covariance()}, covariance.lineSigma()};
  }

 private:
  Eigen::Vector3d row(size_t l) const {
    const double angle = 0.37 * static_cast<double>(l);
    return {100 * std::sin(0.11 * static_cast<double>(l * l)), std::cos(angle), std::sin(angle)};
  }
  /// All lines at an estimate with this error.
  PoseObservation observe(const Twist& error, const Eigen::Vector3d& calibration_error) const {
    PoseObservation seen;
    CameraObservation camera;
    for (size_t l = 0; l < rows_.size(); ++l) {
      const double residual = offsets_[l] + row(l).dot(calibration_error) - rows_[l].dot(error);
      PoseObservation::Piece piece;
      piece.key = static_cast<uint32_t>(l);
      piece.pull = rows_[l];
      piece.offset = residual;
      piece.weight = piece.samples = 1;
      seen.pieces.push_back(piece);
      camera.pose_information += rows_[l] * rows_[l].transpose();
      camera.pose_gradient += residual * rows_[l];
      camera.pull += rows_[l] * row(l).transpose();
      camera.information += row(l) * row(l).transpose();
      camera.gradient += residual * row(l);
    }
    seen.information = camera.pose_information;
    seen.cameras = {camera};
    return seen;
  }

  RandomSource random_;
  std::vector<Vector6> rows_;
  std::vector<double> offsets_;
};

/// Normalised squared errors (NEES) of many buildings, sorted. Of honest covariances they have a
/// chi-square distribution with six degrees of freedom: median 5.35.
std::vector<double> squaredErrors(double line_sigma, double motion_sigma,
                                  const Eigen::Vector3d& calibration_error) {
  std::vector<double> nees;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    const ManyLines::Run run =
        ManyLines(seed, 60, line_sigma).follow(40, motion_sigma, calibration_error);
    nees.push_back(squaredMahalanobis(run.error, run.estimate.covariance));
  }
  std::sort(nees.begin(), nees.end());
  return nees;
}

/// Offsets do not average away over 40 images, whether motion is forgotten at once or slowly. The
/// median of 200 draws has a standard error of 0.25. The unknown calibration adds to the
/// covariance, so the median may be lower.
TEST(EstimateCovariance, IsHonestWhereLinesAreOff) {
  for (const double line_sigma : {0.5, 1.0, 3.0})
    for (const double motion_sigma : {0.01, 0.0003}) {
      const std::vector<double> nees =
          squaredErrors(line_sigma, motion_sigma, Eigen::Vector3d::Zero());
      EXPECT_GT(nees[100], 2.5) << line_sigma << " px, motion " << motion_sigma;
      EXPECT_LT(nees[100], 6.5) << line_sigma << " px, motion " << motion_sigma;
      EXPECT_LT(nees[190], 20) << line_sigma << " px, motion " << motion_sigma;
    }
}

/// A principal point that is off by 8 pixels shows in the residuals. It is known well then, and its
/// known part counts as if it were random, so the covariance may be too large.
TEST(EstimateCovariance, IsHonestWhereTheCalibrationIsOff) {
  const std::vector<double> nees = squaredErrors(0.5, 0.01, {0.004, 8, -5});
  EXPECT_GT(nees[100], 0.5);
  EXPECT_LT(nees[100], 8);
  EXPECT_LT(nees[190], 25);
}

/// A focal length that is off by far more than a usual calibration. Where the images tell it, the
/// prior does not pull it back, so that the covariance holds it. Closed form of one error that the
/// images tell with the standard deviation s: the square of the most likely width of the prior is
/// that of the error less that of s. Below three s it is one hundredth.
TEST(EstimateCovariance, ALargeErrorOfTheFocalLengthIsNotPulledBack) {
  const double s = 0.02;
  for (const double told : {0.08, -0.065, 0.03, 0.002}) {
    EstimateCovariance covariance;
    covariance.reset(Matrix6::Identity());
    PoseObservation seen;
    seen.cameras.resize(1);
    CameraObservation& camera = seen.cameras[0];
    // One image; half of its information counts for offsets of 0.6 pixels.
    const double share = 0.5 * std::pow(0.6 / covariance.lineSigma(), 2);
    camera.information(0, 0) = 1 / (s * s) / share;
    camera.gradient[0] = told / (s * s) / share;
    covariance.correct(seen, Matrix6::Identity());
    const double prior = std::abs(told) > 3 * s ? std::sqrt(told * told - s * s) : 0.01;
    EXPECT_NEAR(covariance.calibrationError()[0], told / (1 + s * s / (prior * prior)),
                1e-3 * std::abs(told))
        << told;
  }
}

TEST(EstimateCovariance, AKnownErrorOfTheFocalLengthIsInTheCovariance) {
  EstimateCovariance covariance;
  covariance.reset(1e-12 * Matrix6::Identity());
  PoseObservation seen;
  seen.information = Matrix6::Identity();
  seen.cameras.resize(1);
  // Things are 3 m away. A motion explains all of the error, so the images do not tell it.
  seen.cameras[0].pull.col(0) << 0, 0, 3, 0, 0, 0;
  seen.cameras[0].pose_information = Matrix6::Identity();
  seen.cameras[0].information(0, 0) = 9;
  covariance.correct(seen, 1e6 * Matrix6::Identity());
  const auto forward = [&] { return std::sqrt(covariance.covariance()(2, 2)); };
  EXPECT_NEAR(forward(), 0.03, 1e-3) << "a usual calibration is off by a hundredth";
  covariance.setFocalError(-0.08);
  EXPECT_NEAR(forward(), std::hypot(0.24, 0.03), 1e-3);
}

TEST(EstimateCovariance, LearnsTheOffsetsOfLines) {
  for (const double sigma : {0.3, 2.0}) {
    double mean = 0;
    for (uint64_t seed = 1; seed <= 20; ++seed)
      mean += ManyLines(seed, 60, sigma).follow(40, 0.01, Eigen::Vector3d::Zero()).line_sigma / 20;
    // Sixty offsets tell their standard deviation to a tenth, twenty runs to a fortieth.
    EXPECT_NEAR(mean, sigma, 0.1 * sigma + 0.02);
  }
}

/// Particles that are spread wide are weighed with the wrong calibration as well, so they do not
/// tell its error. Closed form of one sample: pose Jacobian a, Jacobian b of the principal point.
TEST(EstimateCovariance, SpreadParticlesDoNotTellTheErrorOfTheCalibration) {
  const Vector6 a = (Vector6() << 10, 20, 30, 400, 500, 600).finished();
  const Eigen::Vector3d b(0, 1, 0);
  PoseObservation seen;
  seen.information = a * a.transpose();
  CameraObservation camera{};
  camera.pull = a * b.transpose();
  camera.pose_information = seen.information;
  camera.information = b * b.transpose();
  camera.gradient.setZero();
  camera.pose_gradient.setZero();
  seen.cameras.push_back(camera);
  // The cloud is wider than the errors of motion and lines in every direction.
  const Matrix6 prior = 1e-2 * Matrix6::Identity(), cloud = 2e-2 * Matrix6::Identity();
  EstimateCovariance covariance;
  covariance.reset(prior);
  covariance.correct(seen, prior);
  covariance.widen(cloud);
  const Vector6 shift = (1e2 * Matrix6::Identity() + seen.information).inverse() * a;
  const double five_pixels = 5;  // principal point of a usual calibration
  const Matrix6 expected = cloud + five_pixels * five_pixels * shift * shift.transpose();
  EXPECT_TRUE(covariance.covariance().isApprox(expected, 1e-4));
}

/// Particles that have gathered at a pose tell nothing of errors that all of them share.
TEST(EstimateCovariance, NarrowParticlesTakeNothingAway) {
  Matrix6 wide = 1e-2 * Matrix6::Identity();
  wide(0, 1) = wide(1, 0) = 5e-3;
  Matrix6 cloud = 1e-4 * Matrix6::Identity();
  cloud(5, 5) = 1;  // but for the heading
  EstimateCovariance covariance;
  covariance.reset(wide);
  covariance.widen(cloud);
  wide(5, 5) = 1;
  EXPECT_TRUE(covariance.covariance().isApprox(wide, 1e-6));
}

/// Closed form: a velocity that is off moves the pose by the same amount in every step.
TEST(EstimateCovariance, AnErrorOfTheVelocityDoesNotAverageAway) {
  constexpr double kStep = 0.1, kSigma = 0.3, kNoise = 1e-4;
  constexpr int kSteps = 20;
  EstimateCovariance covariance;
  covariance.reset(Matrix6::Zero());
  covariance.setVelocity(Vector6::Constant(kSigma));
  for (int k = 0; k < kSteps; ++k)
    covariance.moveByVelocity(Pose::Identity(), Vector6::Constant(kNoise), kStep, kStep,
                              Vector6::Zero());
  // The velocity falls to exp(-2 / 5) in 2 s.
  const double distance = kSigma * 5 * (1 - std::exp(-kStep * kSteps / 5));
  const Matrix6 expected = (distance * distance + kNoise * kSteps) * Matrix6::Identity();
  EXPECT_TRUE(covariance.covariance().isApprox(expected, 1e-9));
}

/// A body that accelerates at random, seen in some directions only. The estimate follows it with
/// the velocity that the images tell. @return normalised squared errors of 200 bodies, sorted
std::vector<double> errorsByVelocity(size_t lines) {
  constexpr double kStep = 0.07, kAcceleration = 1, kUsual = 0.5;
  std::vector<double> nees;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    RandomSource random(seed);
    Matrix6 information = Matrix6::Zero();
    for (size_t l = 0; l < lines; ++l) {
      const Twist row = 3000 * random.normalTwist();  // pixels per metre and radian
      information += row * row.transpose();
    }
    Twist pose = Twist::Zero(), velocity = kUsual * random.normalTwist();
    Twist estimate = Twist::Zero(), learnt = Twist::Zero();
    EstimateCovariance covariance;
    covariance.reset(1e-6 * Matrix6::Identity());
    covariance.setVelocity(Vector6::Constant(kUsual));
    for (int k = 0; k < 20; ++k) {
      const double lasting = 5 * (1 - std::exp(-kStep / 5));  // s
      pose += lasting * velocity + 0.005 * random.normalTwist();
      // Velocities have a standard deviation of 0.5 m/s and are forgotten over 5 s.
      const double kept = std::exp(-kStep / 5);
      velocity =
          kept * velocity + 0.5 * kAcceleration * std::sqrt(1 - kept * kept) * random.normalTwist();
      estimate += lasting * learnt;
      learnt *= kept;
      covariance.moveByVelocity(Pose::Identity(), Vector6::Constant(0.005 * 0.005), kStep, kStep,
                                Vector6::Constant(kAcceleration));
      const Matrix6 prior = covariance.ofMotion();
      PoseObservation seen;
      seen.information = information;
      covariance.correct(seen, prior);
      const Twist correction =
          inverseOf(inverseOf(prior) + information) * (information * (pose - estimate));
      estimate += correction;
      learnt += covariance.velocityGain() * correction;
    }
    nees.push_back(squaredMahalanobis(pose - estimate, covariance.covariance()));
  }
  std::sort(nees.begin(), nees.end());
  return nees;
}

/// A body whose images fit one of several poses at random. The estimate jumps among them, which is
/// no motion. @return mean of the squared errors of the velocity over its variance
double velocityErrorAmongModes(double jump) {
  constexpr double kStep = 0.033, kUsual = 0.5, kNoise = 0.002;
  const Matrix6 of_modes = jump * jump * Matrix6::Identity();
  double squares = 0;
  constexpr int kBodies = 200;
  for (uint64_t seed = 1; seed <= kBodies; ++seed) {
    RandomSource random(seed);
    EstimateCovariance covariance;
    covariance.reset(1e-6 * Matrix6::Identity());
    covariance.setVelocity(Vector6::Constant(kUsual));
    Twist pose = Twist::Zero(), estimate = Twist::Zero(), learnt = Twist::Zero();
    Twist velocity = kUsual * random.normalTwist();
    PoseObservation seen;
    seen.information = 1e8 * Matrix6::Identity();  // each pose is seen to a tenth of a millimetre
    for (int k = 0; k < 10; ++k) {
      const double lasting = 5 * (1 - std::exp(-kStep / 5)), kept = std::exp(-kStep / 5);
      pose += lasting * velocity + kNoise * random.normalTwist();
      velocity *= kept;
      estimate += lasting * learnt;
      learnt *= kept;
      covariance.moveByVelocity(Pose::Identity(), Vector6::Constant(kNoise * kNoise), kStep, kStep,
                                Vector6::Zero());
      covariance.correct(seen, covariance.ofMotion(), of_modes);
      const Twist correction = pose + jump * random.normalTwist() - estimate;
      estimate += correction;
      learnt += covariance.velocityGain() * correction;
    }
    squares += (velocity - learnt).cwiseQuotient(covariance.velocitySigma()).squaredNorm() / 6;
  }
  return squares / kBodies;
}

/// The mean of 1200 squares of a normal distribution has a standard error of 0.04. Jumps are taken
/// as independent of one another. But a pose that jumps there jumps back, so the variance is too
/// large.
TEST(EstimateCovariance, AJumpAmongPosesThatFitIsNoMotion) {
  EXPECT_NEAR(velocityErrorAmongModes(0), 1, 0.15);
  for (const double jump : {0.01, 0.06}) {
    EXPECT_LT(velocityErrorAmongModes(jump), 1.3) << jump;
    EXPECT_GT(velocityErrorAmongModes(jump), 0.1) << jump;
  }
}

/// Whether images show no direction, some, or all, the covariance is honest: a chi-square
/// distribution of six degrees of freedom has the median 5.35 and 95 % below 12.6. The median of
/// 200 bodies has a standard error of 0.25.
TEST(EstimateCovariance, IsHonestWithoutOdometry) {
  for (const size_t lines : {0, 2, 4, 12}) {
    const std::vector<double> nees = errorsByVelocity(lines);
    EXPECT_NEAR(nees[100], 5.35, 0.8) << lines << " lines";
    EXPECT_LT(nees[190], 16) << lines << " lines";
  }
}

TEST(EstimateCovariance, WithoutImagesMotionAddsItsNoise) {
  EstimateCovariance covariance;
  covariance.reset(Matrix6::Zero());
  covariance.move(Pose::Identity(), Vector6::Constant(0.01));
  covariance.move(Pose::Identity(), Vector6::Constant(0.02));
  EXPECT_TRUE(covariance.covariance().isApprox(0.03 * Matrix6::Identity(), 1e-9));
}

/// The tangent space turns with the base: an error along x is along -y after a left turn.
TEST(EstimateCovariance, TurnsWithTheBase) {
  EstimateCovariance covariance;
  Matrix6 along_x = Matrix6::Zero();
  along_x(0, 0) = 1;
  covariance.reset(along_x);
  Pose turn = Pose::Identity();
  turn.linear() = expSo3({0, 0, M_PI / 2});
  covariance.move(turn, Vector6::Zero());
  EXPECT_NEAR(covariance.covariance()(1, 1), 1, 1e-9);
  EXPECT_NEAR(covariance.covariance()(0, 0), 0, 1e-9);
}

}  // namespace
}  // namespace edge_mcl
