/// The SE(3) particle filter. It knows plain poses only; CEdgeMonteCarloLocalization3D puts it
/// behind MRPT's interface.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/estimate_covariance.h"
#include "edge_mcl/localization/filter/mode_proposal.h"
#include "edge_mcl/localization/filter/recovery_averages.h"
#include "edge_mcl/localization/filter/tilt_correction.h"

namespace edge_mcl {

/// Result of one update: figures of the particles and of the estimate.
struct UpdateReport {
  double effective_sample_size = 0;  ///< after the update, before resampling
  double tempering = 0;              ///< exponent on the likelihood, summed over the passes
  double visible_samples = 0;        ///< at the estimate, see PoseScore::sample_weight
  double visible_lines = 0;          ///< at the estimate, see PoseScore::line_count
  double log_likelihood = 0;         ///< nats, of the estimate
  /// Mean score of a visible line at the estimate. Robust model: nats. Paper's model: g of eq. (1).
  double evidence_per_line = 0;
  int matched_samples = 0;     ///< samples with an image edge within reach, at the estimate
  int used_samples = 0;        ///< samples that an image edge was searched for, at the estimate
  int depth_points = 0;        ///< points of all depth images that were used
  double depth_bias = 0;       ///< 1/m, the sensor's bias that the filter has learnt, see DepthBias
  double depth_agreement = 0;  ///< share of the depth points on the model, at the estimate
  int refined_modes = 0;       ///< refined poses that particles were drawn around
  double contrast = 0;         ///< of the estimate, see contrastOf()
  double line_sigma = 0;   ///< learnt offset of a line from its image edge, see EstimateCovariance
  double focal_error = 0;  ///< learnt relative error of the focal length
  Eigen::Vector2d centre_error = Eigen::Vector2d::Zero();  ///< of the principal point, pixels
  double injected_share = 0;     ///< share of injected particles, see RecoveryAverages
  int passes = 0;                ///< passes over the images; with more than one, exponents are < 1
  bool has_information = false;  ///< false: no particle sees the model; the pose is a prediction
  /// From the predicted pose to the new estimate, and the covariance that images give this
  /// difference: of the last estimate and of the new one.
  Twist innovation = Twist::Zero();
  Matrix6 innovation_of_images = Matrix6::Zero();
  /// Durations, milliseconds.
  double likelihood_ms = 0, refinement_ms = 0, total_ms = 0;
};

/// Particle filter (sequential Monte-Carlo) over T_map_base.
///
/// The proposal density q is a mixture. One share of the particles moves by odometry or constant
/// velocity, with noise. The other share is drawn around poses that are refined on the present
/// image. Every particle gets the weight likelihood * p / q (balance heuristic: E. Veach, L.
/// Guibas, SIGGRAPH 1995). Here p is the predictive density: a Gaussian fitted to the predicted
/// particles, mixed with a wider Gaussian for unexpected motion.
class PoseFilter {
 public:
  PoseFilter(FilterParameters filter, RefinementParameters refinement);

  /// Draws all particles from a Gaussian over T_map_base. @throws InputError when it is not finite.
  void initialize(const PoseGaussian& gaussian);
  /// Draws all particles around a mean, with independent noise per axis: standard deviations in
  /// metres and radians. @throws InputError when mean or noise is not finite.
  void initialize(const Pose& mean, double std_position, double std_angle);
  /// Replaces all particles. @param poses T_map_base. @param log_weights with any common offset.
  /// @throws Error when there are no particles or the two sizes differ. @throws InputError when a
  /// pose is not finite or a weight is not a number.
  void setParticles(std::vector<Pose> poses, std::vector<double> log_weights);

  /// Resamples if needed and moves all particles by odometry, with noise.
  /// @param increment motion of the base since the last step, in its own frame at that step.
  /// @param dt duration of the motion, seconds. @throws InputError when one of them is not finite
  /// or dt is negative.
  void predictWithOdometry(const Pose& increment, double dt);
  /// Resamples if needed and moves all particles with constant velocity and noise.
  /// @param dt duration that is predicted, seconds. @param elapsed the time that has really passed,
  /// seconds, if it is longer. The velocity is forgotten over this time.
  /// @throws InputError when dt is negative or not finite.
  void predictWithoutOdometry(double dt, std::optional<double> elapsed = std::nullopt);

  /// Sets the velocity of the base, for predictions without odometry, with standard deviations of
  /// 0.2 m/s and 0.2 rad/s. initialize() and setParticles() forget it.
  /// @param velocity base frame, m/s and rad/s.
  void setVelocity(const Twist& velocity);
  /// Standard deviations of the velocity for predictions without odometry, m/s and rad/s.
  Vector6 velocitySigma() const { return covariance_.velocitySigma(); }
  /// The velocity is 0, with the standard deviations of a robot of which nothing is known.
  void forgetVelocity();

  /// Corrects particles and estimate by a reading of roll and pitch. @return false when the reading
  /// contradicts the particles. It is then left out. @throws InputError when the vector is not
  /// finite or shorter than 0.5, or sigma is not positive.
  bool correctTilt(const UpReading& reading);

  /// Weighs the particles by the images and depth images of one moment. Refines the estimate on
  /// them.
  UpdateReport update(const LocalizationMap& map, const std::vector<CameraView>& views);

  /// Factor on the standard deviations of odometry_noise_*, from now on. 1 at the start.
  void setOdometryNoiseFactor(double factor) { odometry_noise_factor_ = factor; }

  /// The focal length is known to be off by this share. The covariance holds it from now on.
  void setFocalError(double error) { covariance_.setFocalError(error); }

  /// Resamples now if the next prediction would resample.
  void resample() { resampleIfNeeded(); }

  /// The particles, T_map_base.
  const std::vector<Pose>& poses() const { return poses_; }
  const std::vector<double>& logWeights() const { return log_weights_; }
  /// Best pose T_map_base and its covariance (tangent space at the pose, base frame).
  const PoseGaussian& estimate() const { return estimate_; }

 private:
  void resampleIfNeeded();
  void addNoise(const Vector6& scale);
  /// @param noise_before noise_variance_ before the noise of this step was added.
  void moveEstimate(const Pose& increment, const Twist& noise_before);
  /// As moveEstimate(), for motion that the velocity predicted. The particles are spread as far as
  /// errors of the velocity may have moved the pose.
  /// @param noise variance of the step. @param elapsed see predictWithoutOdometry()
  void moveByVelocity(const Pose& increment, const Vector6& noise, double dt, double elapsed);
  /// Learns the velocity from an update.
  /// @param predicted the pose that the refinement was pulled to, and the covariance before the
  /// update, without other modes
  void trackVelocity(const PoseGaussian& predicted);
  void correctVelocity(const PoseGaussian& predicted);
  /// One pass: draws particles around refined poses, then multiplies the weights by the tempered
  /// likelihood. @param thinned the views with thinned samples, for the particles.
  /// @param remaining_exponent 1 minus the exponents of the passes before.
  void weigh(const LocalizationMap& map, const std::vector<CameraView>& views,
             const std::vector<CameraView>& thinned, const PredictiveDensity& predictive,
             double remaining_exponent, UpdateReport* report);
  /// Whether the particles are spread wider than the refinement searches: half of its first search
  /// length in the image, or a third of the depth truncation.
  bool spreadBeyondNormals(const LocalizationMap& map, const std::vector<CameraView>& views,
                           const PoseGaussian& cloud) const;
  /// Second moment, about the estimate, of the particles that belong to other modes.
  Matrix6 otherModes(const Pose& centre, const Matrix6& width) const;
  double shareToInject() const;
  void drawTails(const PredictiveDensity& predictive, double share);
  /// Moves equal particles apart, without a change of the cloud's mean and covariance.
  void spreadCopies(const PoseGaussian& cloud);
  /// Refines the mean of the cloud and takes the result as estimate if its posterior is not lower.
  /// @return score of the estimate.
  PoseScore sharpenEstimate(const LocalizationMap& map, const std::vector<CameraView>& views,
                            const PoseGaussian& cloud, const PredictiveDensity& predictive,
                            UpdateReport* report);
  std::vector<CameraView> withoutBias(const LocalizationMap& map, std::vector<CameraView> views);
  void learnBias(const LocalizationMap& map, const std::vector<CameraView>& views,
                 UpdateReport* report);
  std::vector<double> normalizedWeights() const;

  FilterParameters params_;
  RefinementParameters refinement_;
  RandomSource random_;
  std::vector<Pose> poses_;
  std::vector<double> log_weights_;
  /// As log_weights_ after the last update, without tempering.
  std::vector<double> full_log_weights_;
  PoseGaussian estimate_;
  EstimateCovariance covariance_;
  std::map<uint32_t, DepthBias> depth_biases_;  // key: CameraView::depth_sensor
  RecoveryAverages edges_fit_, depth_fit_;
  std::optional<PoseGaussian> last_estimate_;
  double odometry_noise_factor_ = 1;
  double since_last_estimate_ = 0;            // seconds
  Vector6 noise_variance_ = Vector6::Zero();  // sum of the prediction's noise since the last update
  Twist velocity_ = Twist::Zero();            // base frame, m/s and rad/s
};

}  // namespace edge_mcl
