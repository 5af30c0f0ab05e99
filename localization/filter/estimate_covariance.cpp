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
/// Images that the errors of the calibration are learnt from.
constexpr double kRememberedImages = 30;
/// Share of the information of an image that counts, since the same lines are seen again and again.
/// It holds where the pieces are off by kPlainOffset, which is about what the weights of a
/// refinement assume.
constexpr double kNewInformation = 0.5, kPlainOffset = 0.6;  // 1, pixels

Eigen::Matrix3d priorOfCalibration() {
  return Eigen::Vector3d(1 / (kPriorFocal * kPriorFocal), 1 / (kPriorCentre * kPriorCentre),
                         1 / (kPriorCentre * kPriorCentre))
      .asDiagonal();
}

}  // namespace

void EstimateCovariance::reset(const Matrix6& covariance) {
  spread(covariance);
  by_calibration_.setZero();
}

void EstimateCovariance::spread(const Matrix6& covariance) {
  noise_ = refined_ = covariance;
  by_piece_.clear();
}

void EstimateCovariance::move(const Pose& increment, const Vector6& noise_variance) {
  const Matrix6 to_new_axes = adjoint(increment.inverse());
  noise_ = to_new_axes * noise_ * to_new_axes.transpose();
  noise_.diagonal() += noise_variance;
  for (auto& [key, shift] : by_piece_) shift = to_new_axes * shift;
  by_calibration_ = to_new_axes * by_calibration_;
}

void EstimateCovariance::correct(const PoseObservation& seen, const Matrix6& prior) {
  const Matrix6 prior_information = inverseOf(prior + 1e-12 * Matrix6::Identity());
  refined_ = inverseOf(prior_information + seen.information + seen.depth_information);
  const Matrix6 forget = refined_ * prior_information;
  noise_ = forget * noise_ * forget.transpose();
  noise_ += refined_ * seen.depth_information * refined_;
  // A line that has been out of view for long has no effect any more: below a hundredth of a
  // millimetre per pixel.
  constexpr double kNegligible = 1e-5;
  for (auto it = by_piece_.begin(); it != by_piece_.end();) {
    it->second = forget * it->second;
    it = it->second.norm() < kNegligible ? by_piece_.erase(it) : std::next(it);
  }
  for (const PoseObservation::Piece& piece : seen.pieces)
    by_piece_.try_emplace(piece.key, Vector6::Zero()).first->second += refined_ * piece.pull;
  by_calibration_ = forget * by_calibration_;
  for (const CameraObservation& camera : seen.cameras) by_calibration_ += refined_ * camera.pull;
  learnOffsets(seen);
  learnCalibration(seen);
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

Eigen::Vector3d EstimateCovariance::calibrationError() const {
  return (calibration_information_ + priorOfCalibration()).ldlt().solve(calibration_gradient_);
}

Matrix6 EstimateCovariance::covariance() const {
  Matrix6 of_lines = Matrix6::Zero();
  for (const auto& [key, shift] : by_piece_) of_lines.noalias() += shift * shift.transpose();
  const double sigma = lineSigma();
  // The known error counts as well, since it is not removed from the images.
  const Eigen::Vector3d error = calibrationError();
  const Eigen::Matrix3d information = calibration_information_ + priorOfCalibration();
  const Eigen::Matrix3d moment =
      information.ldlt().solve(Eigen::Matrix3d::Identity()) + error * error.transpose();
  return noise_ + sigma * sigma * of_lines + by_calibration_ * moment * by_calibration_.transpose();
}

}  // namespace edge_mcl
