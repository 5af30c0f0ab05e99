/// Covariance of the refined pose, from the errors that this pose really has.
#pragma once

#include <cstdint>
#include <map>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/pose_observation.h"

namespace edge_mcl {

/// Follows how the errors of motion, of the model's lines and of the camera's calibration add up to
/// the error of the estimate.
///
/// An update moves the estimate from its prediction x' to x = A x' + P sum_l p_l b_l, with
/// P = (H + P'^-1)^-1 and A = P P'^-1 (PoseObservation has H and p_l; P' is the prior of the
/// refinement). An error of motion is multiplied by A at every update, so the images forget it. An
/// error b_l of line l is the same in every image, so its share s_l of the error becomes
/// A s_l + P p_l and does not average away. This is the Schmidt-Kalman filter with the lines as
/// considered parameters.
///
/// How large the b_l are is learnt from the residuals of the lines. Errors of focal length and
/// principal point are the same in every image, too. They are learnt from the part of the residuals
/// that no pose explains.
class EstimateCovariance {
 public:
  /// Starts at a pose whose error has nothing to do with the lines.
  void reset(const Matrix6& covariance);
  /// Takes this covariance for the errors of motion and of lines, after correct(). An error of the
  /// calibration has moved the estimate all the same, so its share stays.
  void spread(const Matrix6& covariance);
  /// Moves the pose. @param noise_variance of the step, per axis after the step.
  void move(const Pose& increment, const Vector6& noise_variance);
  /// Adds a correction by images.
  /// @param prior covariance of the Gaussian that the refinement was pulled to.
  void correct(const PoseObservation& seen, const Matrix6& prior);

  /// Covariance of the estimate, in its tangent space (base frame).
  Matrix6 covariance() const;
  /// Covariance after the last correction if lines were independent, as the refinement assumes.
  const Matrix6& refined() const { return refined_; }
  /// Standard deviation of the offset between a piece of a line and its image edge, scaled pixels.
  double lineSigma() const;
  /// Relative error of the focal length, error of the principal point in x and y (pixels).
  Eigen::Vector3d calibrationError() const;

 private:
  void learnOffsets(const PoseObservation& seen);
  void learnCalibration(const PoseObservation& seen);

  Matrix6 noise_ = Matrix6::Zero();    // from the start and from motion
  Matrix6 refined_ = Matrix6::Zero();  // see refined()
  // Error of the estimate per unit of an error. The numbers of pieces fit in memory: at most those
  // of lines that were in view lately.
  std::map<uint32_t, Vector6> by_piece_;
  Eigen::Matrix<double, 6, 3> by_calibration_ = Eigen::Matrix<double, 6, 3>::Zero();
  Eigen::Matrix3d calibration_information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d calibration_gradient_ = Eigen::Vector3d::Zero();
  double squares_ = 0, count_ = 0;  // of the offsets of pieces, pixel^2
};

}  // namespace edge_mcl
