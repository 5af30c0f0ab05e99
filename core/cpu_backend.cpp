#include "edge_mcl/core/cpu_backend.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "edge_mcl/core/cpu_kernel.h"
#include "edge_mcl/core/error.h"

namespace edge_mcl {

double combineLines(const LikelihoodParameters& params, double line_sum, double line_count) {
  if (params.model == LikelihoodModel::kRobust)
    return params.scale * line_sum / (1 + params.line_correlation * std::max(0.0, line_count - 1));
  return std::log(params.alpha) + (line_count > 0 ? params.k * line_sum / line_count : 0);
}

double spacingScale(const LikelihoodFrame& frame) {
  constexpr double kEndOn = 50;
  if (frame.params.model == LikelihoodModel::kPaper) return kEndOn;
  return 0.5 * (frame.camera.fx + frame.camera.fy) * frame.sample_step /
         frame.params.correlation_length;
}

namespace {

constexpr size_t kBlockParticles = 64;

/// The part of space that the cameras of a block can see, as one cone.
struct ViewCone {
  Eigen::Vector3d apex;
  Eigen::Vector3d axis;
  double half_angle;   // including the spread of the orientations
  double apex_radius;  // spread of the positions

  bool misses(const Eigen::Vector3d& centre, double radius) const {
    const Eigen::Vector3d to_centre = centre - apex;
    const double distance = to_centre.norm(), reach = radius + apex_radius;
    if (distance <= reach) return false;
    const double angle = std::acos(std::clamp(axis.dot(to_centre) / distance, -1.0, 1.0));
    return angle > half_angle + std::asin(reach / distance);
  }
};

ViewCone coneOf(double max_view_angle, const std::vector<Pose>& poses,
                const std::vector<uint32_t>& order, size_t begin, size_t end) {
  ViewCone cone;
  cone.apex = Eigen::Vector3d::Zero();
  cone.axis = Eigen::Vector3d::Zero();
  for (size_t i = begin; i < end; ++i) {
    cone.apex += poses[order[i]].translation();
    cone.axis += poses[order[i]].linear().col(2);
  }
  cone.apex /= static_cast<double>(end - begin);
  cone.half_angle = M_PI;
  cone.apex_radius = 0;
  double spread = 0;
  if (cone.axis.norm() > 1e-3) {
    cone.axis.normalize();
    for (size_t i = begin; i < end; ++i)
      spread = std::max(
          spread, std::acos(std::clamp(cone.axis.dot(poses[order[i]].linear().col(2)), -1.0, 1.0)));
    cone.half_angle = spread + max_view_angle + 1e-3;
  }
  for (size_t i = begin; i < end; ++i)
    cone.apex_radius =
        std::max(cone.apex_radius, (poses[order[i]].translation() - cone.apex).norm());
  return cone;
}

/// @param origin near the cameras; the same for every block of a cell, so that a particle's bits
///   do not depend on its neighbours.
void fillSamples(const VisibleSet& set, const ViewCone& cone, const Eigen::Vector3f& origin,
                 bool use_facing, KernelBlock* block) {
  size_t group_begin = 0;  // first kept segment of the open group
  for (const VisibleSet::Segment& segment : set.segments) {
    if (!cone.misses(segment.centre.cast<double>(), segment.radius)) {
      KernelBlock::Segment out{};
      out.tx = segment.tangent.x();
      out.ty = segment.tangent.y();
      out.tz = segment.tangent.z();
      out.first = static_cast<uint32_t>(block->x.size());
      out.count = segment.count;
      out.weight = use_facing ? segment.facing : 1;
      for (uint32_t i = segment.first; i < segment.first + segment.count; ++i) {
        const Eigen::Vector3f p = set.position[i] - origin;
        block->x.push_back(p.x());
        block->y.push_back(p.y());
        block->z.push_back(p.z());
      }
      block->segments.push_back(out);
    }
    if (segment.ends_group) {
      if (block->segments.size() > group_begin) block->segments.back().ends_group = true;
      group_begin = block->segments.size();
    }
  }
}

void fillPoses(const std::vector<Pose>& poses, const std::vector<uint32_t>& order, size_t begin,
               size_t end, const Eigen::Vector3f& origin, KernelBlock* block) {
  block->particles = end - begin;
  const size_t padded = (block->particles + KernelBlock::kLanePadding - 1) /
                        KernelBlock::kLanePadding * KernelBlock::kLanePadding;
  for (auto& plane : block->pose) plane.resize(padded);
  for (size_t lane = 0; lane < padded; ++lane) {
    const Pose& pose = poses[order[begin + std::min(lane, block->particles - 1)]];
    const Eigen::Matrix3d to_camera = pose.linear().transpose();
    const Eigen::Vector3d t = -(to_camera * (pose.translation() - origin.cast<double>()));
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        block->pose[3 * r + c][lane] = static_cast<float>(to_camera(r, c));
      block->pose[9 + r][lane] = static_cast<float>(t[r]);
    }
  }
}

KernelCamera kernelCamera(const CameraModel& camera) {
  KernelCamera k{};
  k.fx = static_cast<float>(camera.fx);
  k.fy = static_cast<float>(camera.fy);
  k.cx = static_cast<float>(camera.cx);
  k.cy = static_cast<float>(camera.cy);
  k.last_x = static_cast<float>(camera.width - 1);
  k.last_y = static_cast<float>(camera.height - 1);
  k.min_depth = static_cast<float>(CameraModel::kMinDepth);
  // The equidistant limit is an angle; the kernel compares squared radii.
  const double limit = camera.distortion == DistortionModel::kEquidistant
                           ? std::pow(std::tan(std::min(std::sqrt(camera.max_radius2), 1.57)), 2)
                           : camera.max_radius2;
  k.max_radius2 = static_cast<float>(limit);
  k.distortion = static_cast<int>(camera.distortion);
  for (int i = 0; i < 8; ++i) k.k[i] = static_cast<float>(camera.coefficients[i]);
  return k;
}

void checkFrame(const LikelihoodFrame& frame) {
  if (!frame.table) throw Error("likelihood: no image table");
  if (frame.table->width() != frame.camera.width || frame.table->height() != frame.camera.height)
    throw InputError("likelihood: the image has " + std::to_string(frame.table->width()) + "x" +
                     std::to_string(frame.table->height()) + " pixels, camera_info says " +
                     std::to_string(frame.camera.width) + "x" +
                     std::to_string(frame.camera.height));
}

/// Particles [begin, end) of `order`, which see `set`. Returns the particle-samples evaluated.
uint64_t scoreRange(const LikelihoodFrame& frame, const VisibleSet& set,
                    const Eigen::Vector3d& near_cameras, double max_view_angle,
                    const std::vector<Pose>& poses, const std::vector<uint32_t>& order,
                    size_t begin, size_t end, std::vector<PoseScore>* scores) {
  const ViewCone cone = coneOf(max_view_angle, poses, order, begin, end);
  KernelBlock block;
  const Eigen::Vector3f origin = near_cameras.cast<float>();
  fillSamples(set, cone, origin, frame.params.model == LikelihoodModel::kRobust, &block);
  fillPoses(poses, order, begin, end, origin, &block);
  const ScoreTable& t = *frame.table;
  const KernelTable table{t.words(), t.width(), t.height(), t.bins(), t.scale(), t.offset()};
  const LikelihoodParameters& p = frame.params;
  const KernelLineRule rule{p.model == LikelihoodModel::kPaper,
                            static_cast<float>(1 / p.line_saturation),
                            p.border_fade > 0 ? static_cast<float>(1 / p.border_fade) : 1e9f,
                            static_cast<float>(spacingScale(frame))};
  std::vector<KernelResult> results(block.particles);
  runKernel(block, kernelCamera(frame.camera), table, rule, results.data());
  for (size_t i = begin; i < end; ++i) {
    const KernelResult& r = results[i - begin];
    (*scores)[order[i]] = {combineLines(p, r.line_sum, r.line_count), r.sample_weight,
                           r.line_count};
  }
  return block.particles * block.x.size();
}

void requireValid(const std::vector<Pose>& poses) {
  for (const Pose& pose : poses)
    if (!pose.matrix().allFinite()) throw Error("likelihood: a pose is not finite");
}

}  // namespace

CpuBackend::CpuBackend(std::shared_ptr<const Visibility> visibility)
    : visibility_(std::move(visibility)) {}

std::string CpuBackend::name() const { return std::string("cpu ") + kernelTargetName(); }

std::vector<PoseScore> CpuBackend::evaluate(const LikelihoodFrame& frame,
                                            const std::vector<Pose>& camera_poses) const {
  checkFrame(frame);
  requireValid(camera_poses);
  std::vector<PoseScore> scores(camera_poses.size());
  std::vector<CellKey> cells(camera_poses.size());
  for (size_t i = 0; i < cells.size(); ++i)
    cells[i] = visibility_->cellOf(camera_poses[i].translation());
  std::vector<uint32_t> order(camera_poses.size());
  std::iota(order.begin(), order.end(), 0u);
  const bool exact = visibility_->exactMode();
  if (!exact)
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return cells[a] == cells[b] ? a < b : cells[a] < cells[b];
    });

  struct Range {
    size_t begin, end;
  };
  std::vector<Range> ranges;
  for (size_t i = 0; i < order.size();) {
    size_t j = i + 1;
    while (!exact && j < order.size() && j - i < kBlockParticles &&
           cells[order[j]] == cells[order[i]])
      ++j;
    ranges.push_back({i, j});
    i = j;
  }
  const double max_view_angle = frame.camera.maxViewAngle();
  std::vector<uint64_t> evaluated(ranges.size());
  tbb::parallel_for(size_t{0}, ranges.size(), [&](size_t r) {
    const uint32_t first = order[ranges[r].begin];
    std::shared_ptr<const VisibleSet> set;
    if (exact)
      set = std::make_shared<VisibleSet>(visibility_->exact(camera_poses[first].translation()));
    else
      set = visibility_->cached(cells[first]);
    evaluated[r] = scoreRange(frame, *set, visibility_->cellCentre(cells[first]), max_view_angle,
                              camera_poses, order, ranges[r].begin, ranges[r].end, &scores);
  });
  last_evaluated_samples_ = std::accumulate(evaluated.begin(), evaluated.end(), uint64_t{0});
  return scores;
}

std::vector<PoseScore> evaluateWithVisibleSet(const LikelihoodFrame& frame, const VisibleSet& set,
                                              const std::vector<Pose>& camera_poses) {
  checkFrame(frame);
  requireValid(camera_poses);
  std::vector<PoseScore> scores(camera_poses.size());
  std::vector<uint32_t> order(camera_poses.size());
  std::iota(order.begin(), order.end(), 0u);
  for (size_t i = 0; i < order.size(); i += kBlockParticles)
    scoreRange(frame, set, camera_poses.front().translation(), frame.camera.maxViewAngle(),
               camera_poses, order, i, std::min(i + kBlockParticles, order.size()), &scores);
  return scores;
}

}  // namespace edge_mcl
