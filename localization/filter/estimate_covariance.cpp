#include "edge_mcl/localization/filter/estimate_covariance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace edge_mcl {

namespace {

/// Offset of a piece of a line before residuals tell it, and the number of pieces that this prior
/// counts as. Edges of a clean model lie half a pixel away, those of a model measured by hand two.
constexpr double kPriorOffset = 1, kPriorPieces = 20;  // scaled pixels
/// The offset is learnt from about this many pieces: some tens of images.
constexpr double kRememberedPieces = 1000;
/// Pieces that the six unknowns of the pose use up, and the fewest from which an offset is learnt.
constexpr double kUnknowns = 6, kFewestPieces = 8;

/// Errors of a usual calibration before images tell them: relative focal length, principal point in
/// pixels. A calibration from a data sheet is off by this much, one with a board by a tenth of it.
constexpr double kPriorFocal = 0.01, kPriorCentre = 5;
/// A calibration of another lens or resolution may be off by this much. It counts when the images
/// tell it by so many standard deviations.
constexpr double kMostFocal = 0.3, kClearFocal = 3;
/// Images that the errors of the calibration are learnt from.
constexpr double kRememberedImages = 30;
/// Share of the information of an image that counts, since the same lines are seen again and again.
/// It holds where the pieces are off by kPlainOffset, which is about what the weights of a
/// refinement assume.
constexpr double kNewInformation = 0.5, kPlainOffset = 0.6;  // 1, pixels

/// A velocity is forgotten over this time: a robot indoors turns or stops.
constexpr double kVelocityTime = 5;  // s
/// Velocity of a robot that accelerates by 1 m/s^2 (rad/s^2), per axis: it is the usual one.
constexpr double kVelocityPerAcceleration = 0.5;  // s

}  // namespace

double keptVelocity(double dt) { return std::exp(-dt / kVelocityTime); }

double timeOfVelocity(double dt) { return kVelocityTime * (1 - keptVelocity(dt)); }

void EstimateCovariance::reset(const Matrix6& covariance) {
  noise_.setZero();
  noise_.topLeftCorner<6, 6>() = refined_ = covariance;
  by_piece_.clear();
  by_calibration_.setZero();
  by_velocity_ = false;
  velocity_gain_.setZero();
  of_modes_.setZero();
  forgetVelocity();
}

void EstimateCovariance::forgetVelocity() {
  Vector6 usual;
  usual << Eigen::Vector3d::Constant(kUsualSpeed), Eigen::Vector3d::Constant(kUsualTurn);
  setVelocity(usual);
}

void EstimateCovariance::setVelocity(const Vector6& sigma) {
  Matrix12 map = Matrix12::Zero();
  map.topLeftCorner<6, 6>().setIdentity();
  transform(map);
  noise_.diagonal().tail<6>() = sigma.cwiseAbs2();
}

void EstimateCovariance::widen(const Matrix6& covariance) {
  noise_.topLeftCorner<6, 6>() += excessOver(ofMotion() + ofLines(), covariance);
  refined_ += excessOver(refined_, covariance);
}

void EstimateCovariance::transform(const Matrix12& map) {
  noise_ = (map * noise_ * map.transpose()).eval();
  noise_ = (0.5 * (noise_ + noise_.transpose())).eval();  // rounding makes it uneven
  const Matrix6 of_pose = map.topLeftCorner<6, 6>();
  of_modes_ = (of_pose * of_modes_ * of_pose.transpose()).eval();
  for (auto& [key, shift] : by_piece_) shift = map * shift;
  by_calibration_ = map * by_calibration_;
}

void EstimateCovariance::move(const Pose& increment, const Vector6& noise_variance) {
  Matrix12 map = Matrix12::Zero();
  map.topLeftCorner<6, 6>() = adjoint(increment.inverse());
  transform(map);
  noise_.diagonal().head<6>() += noise_variance;
  forgetVelocity();
  by_velocity_ = false;
}

void EstimateCovariance::moveByVelocity(const Pose& increment, const Vector6& noise_variance,
                                        double dt, double elapsed, const Vector6& acceleration) {
  const double kept = keptVelocity(elapsed);
  Matrix12 map = kept * Matrix12::Identity();
  map.topLeftCorner<6, 6>() = adjoint(increment.inverse());
  map.topRightCorner<6, 6>() = timeOfVelocity(dt) * Matrix6::Identity();
  transform(map);
  noise_.diagonal().head<6>() += noise_variance;
  noise_.diagonal().tail<6>() +=
      (1 - kept * kept) * (kVelocityPerAcceleration * acceleration).cwiseAbs2();
  by_velocity_ = true;
}

void EstimateCovariance::correct(const PoseObservation& seen, const Matrix6& prior,
                                 const Matrix6& of_modes) {
  const Matrix6 prior_information = inverseOf(prior + 1e-12 * Matrix6::Identity());
  refined_ = inverseOf(prior_information + seen.information + seen.depth_information);
  velocity_gain_.setZero();
  // The pose may have jumped to another mode before, and may do so now.
  const Matrix6 jump = of_modes_ + of_modes;
  if (by_velocity_)
    velocity_gain_ = noise_.bottomLeftCorner<6, 6>() *
                     inverseOf(ofMotion() + jump + 1e-12 * Matrix6::Identity());
  // The pose moves by refined_ * (...) - (1 - forget) * error, and the velocity by the gain times
  // this.
  Matrix12 forget = Matrix12::Identity();
  forget.topLeftCorner<6, 6>() = refined_ * prior_information;
  forget.bottomLeftCorner<6, 6>() =
      velocity_gain_ * (forget.topLeftCorner<6, 6>() - Matrix6::Identity());
  Eigen::Matrix<double, 12, 6> pulled;
  pulled << refined_, velocity_gain_ * refined_;
  transform(forget);
  of_modes_ = of_modes;
  noise_ += pulled * seen.depth_information * pulled.transpose();
  noise_.bottomRightCorner<6, 6>() += velocity_gain_ * jump * velocity_gain_.transpose();
  // A line that has been out of view for long has no effect any more: below a hundredth of a
  // millimetre per pixel.
  constexpr double kNegligible = 1e-5;
  for (auto it = by_piece_.begin(); it != by_piece_.end();)
    it = it->second.norm() < kNegligible ? by_piece_.erase(it) : std::next(it);
  for (const PoseObservation::Piece& piece : seen.pieces)
    by_piece_.try_emplace(piece.key, Vector12::Zero()).first->second += pulled * piece.pull;
  for (const CameraObservation& camera : seen.cameras) by_calibration_ += pulled * camera.pull;
  learnOffsets(seen);
  learnCalibration(seen);
}

Eigen::Matrix<double, 6, 2> EstimateCovariance::correctDirections(
    const Eigen::Matrix<double, 6, 2>& read, double sigma) {
  Eigen::Matrix<double, 12, 2> directions = Eigen::Matrix<double, 12, 2>::Zero();
  directions.topRows<6>() = read;
  const Eigen::Matrix2d known = read.transpose() * ofMotion() * read;
  const double noise = sigma * sigma;
  if (known.trace() < 2 * noise) return Eigen::Matrix<double, 6, 2>::Zero();
  const Eigen::Matrix2d innovation = known + noise * Eigen::Matrix2d::Identity();
  const Eigen::Matrix<double, 12, 2> gain =
      noise_ * directions * innovation.ldlt().solve(Eigen::Matrix2d::Identity());
  transform(Matrix12::Identity() - gain * directions.transpose());
  noise_ += noise * gain * gain.transpose();
  return gain.bottomRows<6>();
}

void EstimateCovariance::learnOffsets(const PoseObservation& seen) {
  double squares = 0, samples = 0, largest = 0;
  for (const PoseObservation::Piece& piece : seen.pieces) {
    squares += piece.samples * piece.offset * piece.offset;
    samples += piece.samples;
    largest = std::max(largest, piece.samples);
  }
  // Pieces of equal weight that tell as much.
  const double pieces = largest > 0 ? samples / largest : 0;
  if (pieces < kFewestPieces) return;
  const double keep = std::max(0.0, 1 - pieces / kRememberedPieces);
  squares_ = keep * squares_ + squares / samples * pieces * pieces / (pieces - kUnknowns);
  count_ = keep * count_ + pieces;
}

void EstimateCovariance::learnCalibration(const PoseObservation& seen) {
  const double sigma = lineSigma();
  const double share = kNewInformation * (kPlainOffset / sigma) * (kPlainOffset / sigma);
  for (const CameraObservation& camera : seen.cameras) {
    // The part of the residuals that no pose explains. An unseen direction of the pose stays free.
    const Matrix6 pose = inverseOf(camera.pose_information + 1e-3 * Matrix6::Identity());
    const Eigen::Matrix<double, 3, 6> explained = camera.pull.transpose() * pose;
    calibration_information_ *= 1 - 1 / kRememberedImages;
    calibration_gradient_ *= 1 - 1 / kRememberedImages;
    calibration_information_ += share * (camera.information - explained * camera.pull);
    calibration_gradient_ += share * (camera.gradient - explained * camera.pose_gradient);
  }
}

double EstimateCovariance::lineSigma() const {
  return std::sqrt((squares_ + kPriorOffset * kPriorOffset * kPriorPieces) /
                   (count_ + kPriorPieces));
}

Eigen::Matrix3d EstimateCovariance::priorOfCalibration() const {
  const Eigen::Matrix2d centre_prior = Eigen::Matrix2d::Identity() / (kPriorCentre * kPriorCentre);
  // What the images alone tell of the focal length, whatever the principal point is.
  const Eigen::Vector2d coupling = calibration_information_.block<2, 1>(1, 0);
  const Eigen::Vector2d share =
      (calibration_information_.bottomRightCorner<2, 2>() + centre_prior).ldlt().solve(coupling);
  const double information = calibration_information_(0, 0) - coupling.dot(share);
  const double gradient = calibration_gradient_[0] - share.dot(calibration_gradient_.tail<2>());
  double variance = kPriorFocal * kPriorFocal;
  if (gradient * gradient > kClearFocal * kClearFocal * information) {
    const double told = gradient / information;
    variance = std::clamp(told * told - 1 / information, variance, kMostFocal * kMostFocal);
  }
  Eigen::Matrix3d prior = Eigen::Matrix3d::Zero();
  prior(0, 0) = 1 / variance;
  prior.bottomRightCorner<2, 2>() = centre_prior;
  return prior;
}

Eigen::Vector3d EstimateCovariance::calibrationError() const {
  return (calibration_information_ + priorOfCalibration()).ldlt().solve(calibration_gradient_);
}

Matrix6 EstimateCovariance::ofLines() const {
  Matrix6 of_lines = Matrix6::Zero();
  for (const auto& [key, shift] : by_piece_)
    of_lines.noalias() += shift.head<6>() * shift.head<6>().transpose();
  const double sigma = lineSigma();
  return sigma * sigma * of_lines;
}

Eigen::Matrix3d EstimateCovariance::momentOfCalibration() const {
  // The known error counts as well, since it is not removed from the images.
  Eigen::Vector3d error = calibrationError();
  if (std::abs(known_focal_error_) > std::abs(error[0])) error[0] = known_focal_error_;
  const Eigen::Matrix3d information = calibration_information_ + priorOfCalibration();
  return information.ldlt().solve(Eigen::Matrix3d::Identity()) + error * error.transpose();
}

Matrix6 EstimateCovariance::covariance() const {
  const Eigen::Matrix<double, 6, 3> shift = by_calibration_.topRows<6>();
  return ofMotion() + ofLines() + shift * momentOfCalibration() * shift.transpose();
}

Vector6 EstimateCovariance::velocitySigma() const {
  Vector6 of_lines = Vector6::Zero();
  for (const auto& [key, shift] : by_piece_) of_lines += shift.tail<6>().cwiseAbs2();
  const double sigma = lineSigma();
  const Eigen::Matrix<double, 6, 3> shift = by_calibration_.bottomRows<6>();
  const Vector6 of_calibration = (shift * momentOfCalibration() * shift.transpose()).diagonal();
  return (noise_.diagonal().tail<6>() + sigma * sigma * of_lines + of_calibration)
      .cwiseMax(0)
      .cwiseSqrt();
}

}  // namespace edge_mcl
