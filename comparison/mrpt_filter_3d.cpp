#include "edge_mcl/comparison/mrpt_filter_3d.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/slam/CMonteCarloLocalization3D.h>

#include <cmath>

#include "edge_mcl/comparison/mrpt_runner.h"
#include "edge_mcl/comparison/surface_points.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/image/image_edges.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

namespace edge_mcl {

struct MrptFilter3D::Filter : public mrpt::slam::CMonteCarloLocalization3D {
  using CMonteCarloLocalization3D::CMonteCarloLocalization3D;
  void set(const std::vector<Pose>& poses) {
    m_particles.resize(poses.size());
    for (size_t i = 0; i < poses.size(); ++i) {
      m_particles[i].d = toMrpt(poses[i]).asTPose();
      m_particles[i].log_w = 0;
    }
  }
  mrpt::bayes::CParticleFilter runner;
};

MrptFilter3D::MrptFilter3D(mrpt::maps::CMetricMap::ConstPtr map, Observe observe,
                           const FilterParameters& params, double power)
    : observe_(std::move(observe)),
      params_(params),
      motion_(params),
      filter_(std::make_unique<Filter>(static_cast<size_t>(params.particles))) {
  filter_->options.metricMap = std::move(map);
  filter_->runner.m_options = runnerOptions(params, power);
}

MrptFilter3D::~MrptFilter3D() = default;

void MrptFilter3D::initialize(const PoseGaussian& start) {
  RandomSource random(params_.seed);
  const Vector6 sigma = start.covariance.diagonal().cwiseSqrt();
  std::vector<Pose> poses;
  poses.reserve(static_cast<size_t>(params_.particles));
  for (int i = 0; i < params_.particles; ++i)
    poses.push_back(normalized(start.mean * expSe3(sigma.cwiseProduct(random.normalTwist())) *
                               opticalOnBody().inverse()));
  filter_->set(poses);
}

Pose MrptFilter3D::process(const LiveInput& input, const Pose&) {
  const Motion motion = motion_.next(input);
  mrpt::obs::CActionRobotMovement3D movement;
  movement.poseChange.mean = toMrpt(opticalOnBody() * motion.increment * opticalOnBody().inverse());
  movement.poseChange.cov.setZero();
  for (int i = 0; i < 6; ++i) movement.poseChange.cov(i, i) = motion.sigma[i] * motion.sigma[i];
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  mrpt::obs::CSensoryFrame frame;
  const mrpt::obs::CObservation::Ptr observation = observe_(input);
  if (observation) frame.insert(observation);
  filter_->runner.executeOn(*filter_, &actions, observation ? &frame : nullptr);
  mrpt::poses::CPose3D mean;
  filter_->getMean(mean);
  return toPose(mean) * opticalOnBody();
}

mrpt::maps::CMetricMap::Ptr pointMapOf(const MeshModel& mesh, double spacing, double sigma) {
  auto map = mrpt::maps::CSimplePointsMap::Create();
  for (const Eigen::Vector3f& p : surfacePoints(mesh, spacing))
    map->insertPointFast(p.x(), p.y(), p.z());
  map->mark_as_modified();
  // MRPT's "sigma_dist" is a variance. Decimation 1 makes MRPT use every point.
  map->likelihoodOptions.sigma_dist = sigma * sigma;
  map->likelihoodOptions.max_corr_distance = 0.3;
  map->likelihoodOptions.decimation = 1;
  return map;
}

MrptFilter3D::Observe observePoints(const DepthParameters& params) {
  return [params](const LiveInput& input) -> mrpt::obs::CObservation::Ptr {
    if (input.depths.empty()) return nullptr;
    const DepthPoints points = makeDepthPoints(input.depths.front().image, params);
    if (points.count == 0) return nullptr;
    auto cloud = mrpt::maps::CSimplePointsMap::Create();
    for (size_t i = 0; i < points.count; ++i)
      cloud->insertPointFast(points.x[i], points.y[i], points.z[i]);
    cloud->mark_as_modified();
    auto observation = mrpt::obs::CObservationPointCloud::Create();
    observation->timestamp = mrpt::Clock::fromDouble(input.time);
    observation->pointcloud = cloud;
    observation->sensorPose = toMrpt(opticalOnBody());
    return observation;
  };
}

MrptFilter3D::Observe observeImages() {
  return [](const LiveInput& input) -> mrpt::obs::CObservation::Ptr {
    if (input.images.empty()) return nullptr;
    const LiveInput::CameraImage& view = input.images.front();
    auto observation = std::make_shared<CObservationMaskedImage>();
    observation->timestamp = mrpt::Clock::fromDouble(input.time);
    observation->cameraPose = toMrpt(opticalOnBody());
    observation->cameraParams = toMrpt(view.camera);
    observation->image = mrpt::img::CImage(toGrey(view.image, view.origin), mrpt::img::DEEP_COPY);
    if (!view.mask.empty())
      observation->ignore_mask = mrpt::img::CImage(view.mask, mrpt::img::DEEP_COPY);
    return observation;
  };
}

}  // namespace edge_mcl
