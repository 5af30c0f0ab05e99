/// The SE(3) particle filter, on plain poses. CEdgeMonteCarloLocalization3D puts it behind MRPT's
/// interface.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/mode_proposal.h"
#include "edge_mcl/localization/filter/recovery_averages.h"
#include "edge_mcl/localization/filter/tilt_correction.h"

namespace edge_mcl {

/// What one update did.
struct UpdateReport {
  double effective_sample_size = 0;  ///< after the update, before resampling
  double tempering = 0;              ///< exponent that was put on the likelihood, all passes
  double visible_samples = 0;        ///< inside the image, at the estimate
  double visible_lines = 0;
  double log_likelihood = 0;  ///< of the estimate
  /// How much a line speaks for the estimate, mean: robust model: nats; paper: g of eq. (1).
  double evidence_per_line = 0;
  int matched_samples = 0;  ///< with an image edge within reach, at the estimate
  int used_samples = 0;
  int depth_points = 0;          ///< of depth images, used
  double depth_bias = 0;         ///< 1/m, see DepthBias: what the filter has learnt of it
  double depth_agreement = 0;    ///< share of them on the model, at the estimate
  int refined_modes = 0;         ///< poses that particles were drawn around
  double injected_share = 0;     ///< of the particles, see RecoveryAverages
  int passes = 0;                ///< how often the image was used, with exponents below one
  bool has_information = false;  ///< false: nothing of the model in the images; only predicted
  double likelihood_ms = 0, refinement_ms = 0, total_ms = 0;
};

/// Sequential Monte-Carlo over T_map_base.
///
/// The proposal is a mixture: a share of the particles moves by odometry (or constant velocity)
/// with noise; the others are drawn around poses refined on the present image. All get the weight
/// likelihood * p / q, p the predictive density (a Gaussian fitted to the predicted particles, with
/// a wider one for the unforeseen), q
/// the mixture (balance heuristic: E. Veach, L. Guibas, SIGGRAPH 1995).
class PoseFilter {
 public:
  PoseFilter(FilterParameters filter, RefinementParameters refinement);

  /// Draws all particles from a Gaussian. @throws Error when it is not finite.
  void initialize(const PoseGaussian& gaussian);
  /// Independent noise per axis: metres, radians.
  void initialize(const Pose& mean, double std_position, double std_angle);
  /// Takes particles over from outside. @param log_weights any common offset.
  void setParticles(std::vector<Pose> poses, std::vector<double> log_weights);

  /// @param increment motion of the base since the last step, in its own frame. @param dt seconds.
  /// @throws Error on an increment that is not finite.
  void predictWithOdometry(const Pose& increment, double dt);
  /// Constant velocity with noise. @param elapsed where more time has passed than is predicted over
  void predictWithoutOdometry(double dt, std::optional<double> elapsed = std::nullopt);

  /// Uses a reading of roll and pitch. @return false when it contradicts the particles, and is left
  /// out. @throws InputError when it is not finite.
  bool correctTilt(const UpReading& reading);

  /// Weighs the particles by the images.
  UpdateReport update(const LocalizationMap& map, const std::vector<CameraView>& views);

  /// Resamples now, if the next prediction would.
  void resample() { resampleIfNeeded(); }

  const std::vector<Pose>& poses() const { return poses_; }
  const std::vector<double>& logWeights() const { return log_weights_; }
  /// Best pose and its covariance (tangent space at the pose, base frame).
  const PoseGaussian& estimate() const { return estimate_; }

 private:
  void resampleIfNeeded();
  void addNoise(const Twist& scale);
  void moveEstimate(const Pose& increment, const Twist& noise_before);
  void trackVelocity();
  void weigh(const LocalizationMap& map, const std::vector<CameraView>& views,
             const std::vector<CameraView>& thinned, const PredictiveDensity& predictive,
             double remaining_exponent, UpdateReport* report);
  bool spreadBeyondNormals(const LocalizationMap& map, const std::vector<CameraView>& views,
                           const PoseGaussian& cloud) const;
  double shareToInject() const;
  void drawTails(const PredictiveDensity& predictive, double share);
  void spreadCopies(const PoseGaussian& cloud);
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
  PoseGaussian estimate_;
  std::map<uint32_t, DepthBias> depth_biases_;  // by CameraView::depth_sensor
  RecoveryAverages edges_fit_, depth_fit_;
  std::optional<PoseGaussian> last_estimate_;
  double since_last_estimate_ = 0;        // seconds
  Twist noise_variance_ = Twist::Zero();  // added by prediction since the last update
  Twist velocity_ = Twist::Zero();        // base frame, per second
};

}  // namespace edge_mcl
