/// The particle filter of edge_mcl behind MRPT's interface.
#pragma once

#include <mrpt/slam/CMonteCarloLocalization3D.h>

#include "edge_mcl/localization/filter/pose_filter.h"
#include "edge_mcl/mrpt_plugins/CEdgeMap.h"

namespace edge_mcl {

/// Replaces mrpt::slam::CMonteCarloLocalization3D with the standard proposal. Poses are T_map_base.
///
/// The filter scores all particles in one batch and composes odometry on SE(3). When an action
/// holds no movement, it uses a constant-velocity model. It tempers each image and draws a share of
/// the particles around refined poses. It resamples systematically by itself, so that
/// CParticleFilter finds equal weights and does not resample.
class CEdgeMonteCarloLocalization3D : public mrpt::slam::CMonteCarloLocalization3D {
 public:
  /// Takes number of particles, seed and noise from the parameters of the map.
  /// @param map must hold a loaded model. @throws Error when it does not.
  explicit CEdgeMonteCarloLocalization3D(std::shared_ptr<const CEdgeMap> map);

  /// Draws all particles from a Gaussian over T_map_base. @throws InputError when it is not finite.
  void initialize(const PoseGaussian& gaussian);

  /// Predicts by the action, weighs by the observations, resamples. `options` are not used.
  /// @param action a 3D or 2D movement of the base; null or without movement: constant velocity.
  /// @param observation the observations of one moment; null: prediction only.
  /// @throws InputError when the time of the observations goes back or an observation is not valid.
  void prediction_and_update_pfStandardProposal(
      const mrpt::obs::CActionCollection* action, const mrpt::obs::CSensoryFrame* observation,
      const mrpt::bayes::CParticleFilter::TParticleFilterOptions& options) override;

  /// Best pose T_map_base with its covariance on SE(3).
  const PoseGaussian& estimate() const { return filter_.estimate(); }
  /// Report of the last update with observations that the map can use.
  const UpdateReport& report() const { return report_; }

  /// Covariance and mean of the estimate, in MRPT's coordinates (x, y, z, yaw, pitch, roll; metres
  /// and radians). The version of the base class loses the sign of cross-covariances.
  std::tuple<cov_mat_t, type_value> getCovarianceAndMean() const override;
  void getMean(mrpt::poses::CPose3D& mean) const override;

 private:
  /// Hands particles that were set through the base class to the filter.
  void takeParticles();
  /// Copies the particles of the filter to the base class.
  void publishParticles();

  std::shared_ptr<const CEdgeMap> map_;
  PoseFilter filter_;
  UpdateReport report_;
  double last_time_ = -1;  // of the last observation, seconds; negative: there was none
};

}  // namespace edge_mcl
