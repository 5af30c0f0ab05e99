/// edge_mcl's particle filter behind MRPT's interface.
#pragma once

#include <mrpt/slam/CMonteCarloLocalization3D.h>

#include "edge_mcl/localization/filter/pose_filter.h"
#include "edge_mcl/mrpt_plugins/CEdgeMap.h"

namespace edge_mcl {

/// Drop-in for mrpt::slam::CMonteCarloLocalization3D with the standard proposal: scores all
/// particles in one batch, composes odometry on SE(3), uses a constant-velocity model when an
/// action holds no movement, tempers each image, draws particles to refined poses, and resamples
/// systematically by itself (so that CParticleFilter finds equal weights and does not).
/// Poses are of the robot's base in the map.
class CEdgeMonteCarloLocalization3D : public mrpt::slam::CMonteCarloLocalization3D {
 public:
  /// Number of particles, seed and noise come from the map's parameters.
  /// @param map must hold a loaded model.
  explicit CEdgeMonteCarloLocalization3D(std::shared_ptr<const CEdgeMap> map);

  void initialize(const PoseGaussian& gaussian);

  void prediction_and_update_pfStandardProposal(
      const mrpt::obs::CActionCollection* action, const mrpt::obs::CSensoryFrame* observation,
      const mrpt::bayes::CParticleFilter::TParticleFilterOptions& options) override;

  /// Best pose with covariance on SE(3).
  const PoseGaussian& estimate() const { return filter_.estimate(); }
  const UpdateReport& report() const { return report_; }

  /// Of the estimate, in MRPT's coordinates (x, y, z, yaw, pitch, roll). The base class loses the
  /// sign of cross-covariances.
  std::tuple<cov_mat_t, type_value> getCovarianceAndMean() const override;
  void getMean(mrpt::poses::CPose3D& mean) const override;

 private:
  void takeParticles();
  void publishParticles();

  std::shared_ptr<const CEdgeMap> map_;
  PoseFilter filter_;
  UpdateReport report_;
  double last_time_ = -1;  // seconds
};

}  // namespace edge_mcl
