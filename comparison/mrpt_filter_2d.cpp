#include "edge_mcl/comparison/mrpt_filter_2d.h"

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPosePDFGaussian.h>
#include <mrpt/slam/CMonteCarloLocalization2D.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/comparison/mrpt_runner.h"
#include "edge_mcl/comparison/surface_points.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

namespace edge_mcl {

namespace {

double headingOf(const Pose& body) { return std::atan2(body.linear()(1, 0), body.linear()(0, 0)); }

/// Returns the pose with heading, x and y set to 0. Height, roll and pitch stay.
Pose levelled(const Pose& body) {
  Pose level = Pose::Identity();
  level.linear() = rotationFromAngles(0, 0, -headingOf(body)) * body.linear();
  level.translation().z() = body.translation().z();
  return level;
}

}  // namespace

struct MrptFilter2D::Filter : public mrpt::slam::CMonteCarloLocalization2D {
  using CMonteCarloLocalization2D::CMonteCarloLocalization2D;
  void set(const std::vector<mrpt::math::TPose2D>& poses) {
    m_particles.resize(poses.size());
    for (size_t i = 0; i < poses.size(); ++i) {
      m_particles[i].d = poses[i];
      m_particles[i].log_w = 0;
    }
  }
  mrpt::bayes::CParticleFilter runner;
};

mrpt::maps::COccupancyGridMap2D::Ptr floorPlanOf(const MeshModel& mesh, double height,
                                                 const FloorPlanParameters& params) {
  constexpr double kMargin = 0.5;
  auto grid = mrpt::maps::COccupancyGridMap2D::Create(
      mesh.lowest.x() - kMargin, mesh.highest.x() + kMargin, mesh.lowest.y() - kMargin,
      mesh.highest.y() + kMargin, params.cell);
  grid->fill(0.95F);  // free
  for (const auto& [from, to] : sectionOf(mesh, height)) {
    const int steps =
        std::max(1, static_cast<int>(std::ceil((to - from).norm() / params.cell * 2)));
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2f p =
          from + (to - from) * (static_cast<float>(i) / static_cast<float>(steps));
      grid->setCell(grid->x2idx(p.x()), grid->y2idx(p.y()), 0.02F);
    }
  }
  auto& likelihood = grid->likelihoodOptions;
  likelihood.likelihoodMethod = mrpt::maps::COccupancyGridMap2D::lmLikelihoodField_Thrun;
  likelihood.LF_stdHit = static_cast<float>(params.sigma_hit);
  likelihood.LF_decimation = 1;
  likelihood.LF_maxRange = 20;
  return grid;
}

mrpt::obs::CObservation2DRangeScan::Ptr scanOf(const DepthPoints& points, const Pose& level_camera,
                                               double height, const FloorPlanParameters& params) {
  const auto count = static_cast<size_t>(std::lround(params.field_of_view_deg / params.ray_deg));
  std::vector<std::vector<float>> ranges(count);
  const double field_of_view = params.field_of_view_deg * kDegree;
  for (size_t i = 0; i < points.count; ++i) {
    const Eigen::Vector3d p = level_camera * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]);
    if (std::abs(p.z() - height) > params.slab) continue;
    const double bearing = std::atan2(p.y(), p.x()) / field_of_view + 0.5;
    if (bearing < 0 || bearing >= 1) continue;
    const auto ray = static_cast<size_t>(bearing * static_cast<double>(count));
    ranges[ray].push_back(static_cast<float>(std::hypot(p.x(), p.y())));
  }
  auto scan = mrpt::obs::CObservation2DRangeScan::Create();
  // Every ray has the direction of the middle of its bin, so the aperture is one bin smaller.
  scan->aperture = static_cast<float>(field_of_view * static_cast<double>(count - 1) /
                                      static_cast<double>(count));
  scan->rightToLeft = true;
  scan->maxRange = 20;
  scan->resizeScan(count);
  size_t hits = 0;
  for (size_t i = 0; i < count; ++i) {
    std::vector<float>& r = ranges[i];
    scan->setScanRangeValidity(i, !r.empty());
    scan->setScanRange(i, 0);
    if (r.empty()) continue;
    std::nth_element(r.begin(), r.begin() + static_cast<long>(r.size() / 2), r.end());
    scan->setScanRange(i, r[r.size() / 2]);
    ++hits;
  }
  constexpr size_t kFewestHits = 5;
  return hits < kFewestHits ? nullptr : scan;
}

MrptFilter2D::MrptFilter2D(const MeshModel& mesh, double height, const FilterParameters& params,
                           const DepthParameters& depth, const FloorPlanParameters& plan,
                           double power)
    : height_(height),
      params_(params),
      depth_(depth),
      plan_(plan),
      motion_(params),
      filter_(std::make_unique<Filter>(static_cast<size_t>(params.particles))) {
  // Only the points of one height are used, so the filter takes more points than the depth cue.
  depth_.points = 5000;
  filter_->options.metricMap = floorPlanOf(mesh, height, plan);
  filter_->runner.m_options = runnerOptions(params, power);
}

MrptFilter2D::~MrptFilter2D() = default;

void MrptFilter2D::initialize(const PoseGaussian& start) {
  RandomSource random(params_.seed);
  const Vector6 sigma = start.covariance.diagonal().cwiseSqrt();
  std::vector<mrpt::math::TPose2D> poses;
  for (int i = 0; i < params_.particles; ++i) {
    const Pose body =
        start.mean * expSe3(sigma.cwiseProduct(random.normalTwist())) * opticalOnBody().inverse();
    poses.emplace_back(body.translation().x(), body.translation().y(), headingOf(body));
  }
  filter_->set(poses);
}

Pose MrptFilter2D::process(const LiveInput& input, const Pose& truth) {
  const Motion motion = motion_.next(input);
  const Pose level = levelled(truth * opticalOnBody().inverse());
  // Motion in the plane, computed with the roll and pitch before the motion.
  const Pose moved =
      last_level_.value_or(level) * opticalOnBody() * motion.increment * opticalOnBody().inverse();
  last_level_ = level;
  mrpt::poses::CPosePDFGaussian change;
  change.mean = {moved.translation().x(), moved.translation().y(), headingOf(moved)};
  change.cov.setZero();
  change.cov(0, 0) = change.cov(1, 1) = motion.sigma[0] * motion.sigma[0];
  change.cov(2, 2) = motion.sigma[3] * motion.sigma[3];
  mrpt::obs::CActionRobotMovement2D movement;
  movement.poseChange = mrpt::poses::CPosePDFGaussian::Create(change);
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  mrpt::obs::CSensoryFrame frame;
  if (!input.depths.empty()) {
    const auto scan = scanOf(makeDepthPoints(input.depths.front().image, depth_),
                             level * opticalOnBody(), height_, plan_);
    if (scan) frame.insert(scan);
  }
  filter_->runner.executeOn(*filter_, &actions, frame.empty() ? nullptr : &frame);
  mrpt::poses::CPose2D mean;
  filter_->getMean(mean);
  Pose body = level;
  body.linear() = rotationFromAngles(0, 0, mean.phi()) * level.linear();
  body.translation().x() = mean.x();
  body.translation().y() = mean.y();
  return body * opticalOnBody();
}

}  // namespace edge_mcl
