/// Covariance of the refined pose, from the errors that this pose really has.
#pragma once

#include <cstdint>
#include <map>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/pose_observation.h"

namespace edge_mcl {

/// Standard deviations, per axis, of the velocity of a robot of which nothing is known: it flies
/// indoors. m/s, rad/s
constexpr double kUsualSpeed = 0.5, kUsualTurn = 0.5;

/// Share of a velocity that is left after a time. Velocities are an Ornstein-Uhlenbeck process, so
/// that a robot that is not seen does not fly on for ever. @param dt s
double keptVelocity(double dt);
/// Time for which the velocity at the beginning would have to last, to move as far as a velocity
/// that is forgotten. It is at most 5 s, however long the clock says. @param dt s
double timeOfVelocity(double dt);

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
/// Without odometry the motion is predicted by a velocity. An error of the velocity moves the
/// prediction by the same amount in every step, so it does not average away where images do not
/// show the motion. So the velocity has errors of its own here, and an update moves the velocity v
/// by the gain of a Kalman filter: v = v' + C^T M^-1 (x - x'). C is the covariance of the errors of
/// pose and velocity, and M that of the pose by start and motion. Errors of lines are no motion, so
/// they do not count in M. Other poses that fit the images as well do count.
///
/// How large the b_l are is learnt from the residuals of the lines. Errors of focal length and
/// principal point are the same in every image, too. They are learnt from the part of the residuals
/// that no pose explains. A usual calibration is off by a hundredth. Where the images tell more, by
/// three standard deviations, the prior of the focal length has the most likely width (empirical
/// Bayes; D. J. C. MacKay, "Bayesian interpolation", Neural Computation 4(3), 1992).
class EstimateCovariance {
 public:
  EstimateCovariance() { reset(Matrix6::Zero()); }
  /// Starts at a pose whose error has nothing to do with the lines. The velocity is that of a robot
  /// of which nothing is known.
  void reset(const Matrix6& covariance);
  /// The velocity has become known. @param sigma standard deviations, m/s and rad/s
  void setVelocity(const Vector6& sigma);
  /// Nothing is known of the velocity any more.
  void forgetVelocity();
  /// Whether the last motion was predicted by the velocity.
  bool isByVelocity() const { return by_velocity_; }
  /// Widens the errors of motion and of lines to this covariance in the directions in which they
  /// are smaller.
  void widen(const Matrix6& covariance);
  /// Moves the pose by odometry. @param noise_variance of the step, per axis after the step.
  void move(const Pose& increment, const Vector6& noise_variance);
  /// Moves the pose by the velocity.
  /// @param dt duration of the motion, s. @param elapsed time over which the velocity was
  /// forgotten, s. @param acceleration standard deviation of accelerations, m/s^2 and rad/s^2
  void moveByVelocity(const Pose& increment, const Vector6& noise_variance, double dt,
                      double elapsed, const Vector6& acceleration);
  /// Adds a correction by images.
  /// @param prior covariance of the Gaussian that the refinement was pulled to. @param of_modes
  /// second moment of other poses that fit the images as well. The pose may jump between them, and
  /// a jump is no motion, so it tells as much less of the velocity.
  void correct(const PoseObservation& seen, const Matrix6& prior,
               const Matrix6& of_modes = Matrix6::Zero());
  /// Adds a measurement of two directions of the pose, if it is more exact than what is known. The
  /// errors of such readings last, so that many of them are no better than one.
  /// @param read the directions, base frame. @param sigma of the measurement
  /// @return correction of the velocity for the error along these directions
  Eigen::Matrix<double, 6, 2> correctDirections(const Eigen::Matrix<double, 6, 2>& read,
                                                double sigma);
  /// The relative error of the focal length is at least this, other than the residuals tell.
  void setFocalError(double error) { known_focal_error_ = error; }
  /// Correction of the velocity for a correction of the pose in the last correct(), 1/s. It is 0
  /// when the motion was not predicted by the velocity.
  const Matrix6& velocityGain() const { return velocity_gain_; }

  /// Covariance of the estimate, in its tangent space (base frame).
  Matrix6 covariance() const;
  /// The part of the covariance that comes from the start, from motion and from depth.
  Matrix6 ofMotion() const { return noise_.topLeftCorner<6, 6>(); }
  /// Standard deviations of the velocity, whatever the cause of its errors, m/s and rad/s.
  Vector6 velocitySigma() const;
  /// Covariance after the last correction if lines were independent, as the refinement assumes.
  const Matrix6& refined() const { return refined_; }
  /// Standard deviation of the offset between a piece of a line and its image edge, scaled pixels.
  double lineSigma() const;
  /// Relative error of the focal length, error of the principal point in x and y (pixels).
  Eigen::Vector3d calibrationError() const;

 private:
  using Vector12 = Eigen::Matrix<double, 12, 1>;  // errors of pose and velocity
  using Matrix12 = Eigen::Matrix<double, 12, 12>;

  void learnOffsets(const PoseObservation& seen);
  void learnCalibration(const PoseObservation& seen);
  /// Information about the errors of the calibration before images tell them.
  Eigen::Matrix3d priorOfCalibration() const;
  /// Applies a linear map to the errors of pose and velocity, whatever their cause.
  void transform(const Matrix12& map);
  Matrix6 ofLines() const;
  /// Second moment of the errors of the calibration, the known one among them.
  Eigen::Matrix3d momentOfCalibration() const;

  Matrix12 noise_;                     // from the start and from motion
  Matrix6 refined_ = Matrix6::Zero();  // see refined()
  bool by_velocity_ = false;           // the last motion was predicted by the velocity
  Matrix6 velocity_gain_ = Matrix6::Zero();
  Matrix6 of_modes_ = Matrix6::Zero();  // of the last correction, moved since
  // Errors of pose and velocity per unit of an offset or error. The numbers of pieces fit in
  // memory: at most those of lines that were in view lately.
  std::map<uint32_t, Vector12> by_piece_;
  Eigen::Matrix<double, 12, 3> by_calibration_ = Eigen::Matrix<double, 12, 3>::Zero();
  Eigen::Matrix3d calibration_information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d calibration_gradient_ = Eigen::Vector3d::Zero();
  double known_focal_error_ = 0;
  double squares_ = 0, count_ = 0;  // of the offsets of pieces, pixel^2
};

}  // namespace edge_mcl
