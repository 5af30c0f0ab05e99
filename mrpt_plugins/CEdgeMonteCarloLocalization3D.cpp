#include "edge_mcl/mrpt_plugins/CEdgeMonteCarloLocalization3D.h"

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CSensoryFrame.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

namespace edge_mcl {

CEdgeMonteCarloLocalization3D::CEdgeMonteCarloLocalization3D(std::shared_ptr<const CEdgeMap> map)
    : CMonteCarloLocalization3D(static_cast<size_t>(map->localization().params().filter.particles)),
      map_(std::move(map)),
      filter_(map_->localization().params().filter, map_->localization().params().refinement) {
  options.metricMap = map_;
}

void CEdgeMonteCarloLocalization3D::initialize(const PoseGaussian& gaussian) {
  filter_.initialize(gaussian);
  last_time_ = -1;
  publishParticles();
}

void CEdgeMonteCarloLocalization3D::publishParticles() {
  m_particles.resize(filter_.poses().size());
  for (size_t i = 0; i < m_particles.size(); ++i) {
    m_particles[i].d = toMrpt(filter_.poses()[i]).asTPose();
    m_particles[i].log_w = filter_.logWeights()[i];
  }
}

void CEdgeMonteCarloLocalization3D::takeParticles() {
  // A caller may have set particles through the base class (resetUniform, resetDeterministic).
  bool changed = m_particles.size() != filter_.poses().size();
  for (size_t i = 0; i < m_particles.size() && !changed; ++i)
    changed = !(m_particles[i].d == toMrpt(filter_.poses()[i]).asTPose());
  if (!changed) return;
  std::vector<Pose> poses;
  std::vector<double> log_weights;
  for (const auto& particle : m_particles) {
    poses.push_back(toPose(particle.d));
    log_weights.push_back(particle.log_w);
  }
  filter_.setParticles(std::move(poses), std::move(log_weights));
}

void CEdgeMonteCarloLocalization3D::prediction_and_update_pfStandardProposal(
    const mrpt::obs::CActionCollection* action, const mrpt::obs::CSensoryFrame* observation,
    const mrpt::bayes::CParticleFilter::TParticleFilterOptions&) {
  takeParticles();
  double dt = 0;
  if (observation && !observation->empty()) {
    const double time = mrpt::Clock::toDouble(observation->getObservationByIndex(0)->timestamp);
    if (last_time_ >= 0) {
      dt = time - last_time_;
      if (dt < 0) throw InputError("filter: the time of the observations goes back");
    }
    last_time_ = time;
  }
  mrpt::obs::CActionRobotMovement3D::Ptr movement_3d;
  mrpt::obs::CActionRobotMovement2D::Ptr movement_2d;
  if (action) {
    movement_3d = action->getActionByClass<mrpt::obs::CActionRobotMovement3D>();
    movement_2d = action->getBestMovementEstimation();
  }
  if (movement_3d)
    filter_.predictWithOdometry(toPose(movement_3d->poseChange.mean), dt);
  else if (movement_2d)
    filter_.predictWithOdometry(toPose(mrpt::poses::CPose3D(movement_2d->poseChange->getMeanVal())),
                                dt);
  else if (dt > 0)
    filter_.predictWithoutOdometry(dt);

  std::vector<CameraView> views;
  if (observation)
    for (const auto& o : *observation)
      for (CameraView& view : map_->views(*o)) views.push_back(std::move(view));
  if (!views.empty()) report_ = filter_.update(map_->localization(), views);
  filter_.resample();
  publishParticles();
}

std::tuple<CEdgeMonteCarloLocalization3D::cov_mat_t, CEdgeMonteCarloLocalization3D::type_value>
CEdgeMonteCarloLocalization3D::getCovarianceAndMean() const {
  return {toMrptCovariance(estimate()), toMrpt(estimate().mean)};
}

void CEdgeMonteCarloLocalization3D::getMean(mrpt::poses::CPose3D& mean) const {
  mean = toMrpt(estimate().mean);
}

}  // namespace edge_mcl
