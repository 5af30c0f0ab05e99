#include "edge_mcl/core/likelihood/cpu_backend.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numeric>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/likelihood/cpu_kernel.h"
#include "edge_mcl/core/likelihood/segment_union.h"

namespace edge_mcl {

double combineLines(const LikelihoodParameters& params, double line_sum, double line_count) {
  if (params.model == LikelihoodModel::kRobust)
    return params.scale * line_sum / (1 + params.line_correlation * std::max(0.0, line_count - 1));
  return std::log(params.alpha) + (line_count > 0 ? params.k * line_sum / line_count : 0);
}

double scorePerLine(const LikelihoodParameters& params, double log_likelihood, double line_count) {
  if (!(line_count > 0)) return 0;
  if (params.model == LikelihoodModel::kRobust)
    return log_likelihood * (1 + params.line_correlation * std::max(0.0, line_count - 1)) /
           (params.scale * line_count);
  return (log_likelihood - std::log(params.alpha)) / params.k;
}

double spacingScale(const LikelihoodFrame& frame) {
  constexpr double kEndOn = 50;
  if (frame.params.model == LikelihoodModel::kPaper)
    return kEndOn * 2 / (frame.camera.fx + frame.camera.fy);
  return frame.sample_step * frame.thinning / frame.params.correlation_length;
}

std::shared_ptr<const ScoreTable> LikelihoodFrame::tableHere() const {
  if (table) return table;
  if (!picture) throw Error("likelihood: no image table");
  return picture->table();
}

void checkFrame(const LikelihoodFrame& frame) {
  if (!frame.table && !frame.picture) throw Error("likelihood: no image table");
  const int width = frame.table ? frame.table->width() : frame.picture->grey().cols;
  const int height = frame.table ? frame.table->height() : frame.picture->grey().rows;
  if (width != frame.camera.width || height != frame.camera.height)
    throw InputError("likelihood: the image has " + std::to_string(width) + "x" +
                     std::to_string(height) + " pixels, camera_info says " +
                     std::to_string(frame.camera.width) + "x" +
                     std::to_string(frame.camera.height));
}

void checkPose(const Pose& pose) {
  if (!pose.matrix().allFinite()) throw Error("likelihood: a pose is not finite");
}

void checkLikelihoodInput(const LikelihoodFrame& frame, const std::vector<Pose>& camera_poses) {
  checkFrame(frame);
  for (const Pose& pose : camera_poses) checkPose(pose);
}

namespace {

/// Data that all particles of a batch share.
struct Batch {
  const LikelihoodFrame* frame;
  std::shared_ptr<const ScoreTable> table;
  const std::vector<Pose>* poses;
  std::vector<uint32_t> order;  ///< particles, ordered by cell
  std::vector<uint32_t> cell;   ///< of every particle: index into sets
  std::vector<std::shared_ptr<const VisibleSet>> sets;

  /// Of every segment that a set holds: samples that remain after thinning; empty: all.
  std::vector<uint16_t> used;

  const Pose& pose(size_t i) const { return (*poses)[order[i]]; }
  uint32_t usedOf(uint32_t segment) const { return used.empty() ? 0xffffu : used[segment]; }

  void thin(const EdgeModel& model) {
    if (frame->thinning <= 1) return;
    used.assign(model.segments.size(), 0);
    for (const auto& set : sets)
      for (const VisibleSet::Segment& s : set->segments)
        if (used[s.index] == 0)
          used[s.index] = usedSamples(model.segments[s.index], frame->thinning);
  }
};

/// Cone around the part of space that the cameras of a block can see.
struct BlockCone {
  Eigen::Vector3d apex;
  Eigen::Vector3d axis;
  double sin_half, cos_half;  // half the opening angle, with the spread of the orientations
  double apex_radius;         // spread of the positions, metres

  /// Whether a sphere lies outside the cone.
  bool misses(const Eigen::Vector3d& centre, double radius) const {
    const Eigen::Vector3d to_centre = centre - apex;
    const double distance = to_centre.norm(), reach = radius + apex_radius;
    if (distance <= reach) return false;
    // Is the angle to the axis larger than half_angle + asin(reach / distance)?
    const double sine = reach / distance, cosine = std::sqrt(1 - sine * sine);
    if (sin_half * cosine + cos_half * sine <= 0) return false;  // their sum is pi or more
    return axis.dot(to_centre) < distance * (cos_half * cosine - sin_half * sine);
  }
};

/// Cone of particles [begin, end) of the batch's order.
BlockCone coneOf(const Batch& batch, size_t begin, size_t end) {
  BlockCone cone;
  cone.apex = Eigen::Vector3d::Zero();
  cone.axis = Eigen::Vector3d::Zero();
  for (size_t i = begin; i < end; ++i) {
    cone.apex += batch.pose(i).translation();
    cone.axis += batch.pose(i).linear().col(2);
  }
  cone.apex /= static_cast<double>(end - begin);
  double half_angle = M_PI;
  cone.apex_radius = 0;
  if (cone.axis.norm() > 1e-3) {
    cone.axis.normalize();
    double spread = 0;
    for (size_t i = begin; i < end; ++i)
      spread = std::max(
          spread, std::acos(std::clamp(cone.axis.dot(batch.pose(i).linear().col(2)), -1.0, 1.0)));
    half_angle = std::min(M_PI, spread + batch.frame->camera.view.angle + 1e-3);
  }
  cone.sin_half = std::sin(half_angle);
  cone.cos_half = std::cos(half_angle);
  for (size_t i = begin; i < end; ++i)
    cone.apex_radius = std::max(cone.apex_radius, (batch.pose(i).translation() - cone.apex).norm());
  return cone;
}

/// Merges the visible sets of the block's cells into the block's list of segments.
/// @param cells distinct indices into batch.sets.
void fillSegments(const Batch& batch, const std::vector<uint32_t>& cells, const BlockCone& cone,
                  KernelBlock* block) {
  const EdgeModel& model = *batch.sets[cells.front()]->model;
  SegmentUnion merged(model.segments.size());
  for (const uint32_t c : cells)
    for (const VisibleSet::Segment& s : batch.sets[c]->segments)
      if (s.samples & batch.usedOf(s.index)) merged.insert(s.index);
  const std::vector<uint32_t> indices = merged.filter([&](uint32_t k) {
    const EdgeSegment& s = model.segments[k];
    return !cone.misses(s.centre.cast<double>(), s.radius);
  });
  block->along = model.sample_along.data();
  block->cells = static_cast<uint32_t>(cells.size());
  block->segments.resize(indices.size());
  block->seen.assign(indices.size() * cells.size(), 0);
  const bool use_facing = batch.frame->params.model == LikelihoodModel::kRobust;
  for (size_t c = 0; c < cells.size(); ++c)
    for (const VisibleSet::Segment& s : batch.sets[cells[c]]->segments) {
      const int32_t k = merged.rank(s.index);
      if (k < 0) continue;
      const uint32_t facing = use_facing ? s.facing : 65535u;
      const uint32_t samples = s.samples & batch.usedOf(s.index);
      block->seen[k * cells.size() + c] = samples | facing << 16;
      block->segments[k].samples |= samples;
    }
  for (size_t k = 0; k < indices.size(); ++k) {
    const EdgeSegment& s = model.segments[indices[k]];
    const EdgeLine& line = model.lines[s.line];
    KernelBlock::Segment& out = block->segments[k];
    Eigen::Map<Eigen::Vector3d>(out.centre) = s.centre.cast<double>();
    Eigen::Map<Eigen::Vector3f>(out.tangent) = line.tangent();
    out.radius = s.radius;
    out.first = s.first_sample;
    out.ends_group = k + 1 == indices.size() ||
                     model.lines[model.segments[indices[k + 1]].line].group != line.group;
  }
}

/// Copies the poses of particles [begin, end) of the batch's order into the block.
void fillParticles(const Batch& batch, const std::vector<uint32_t>& cells, size_t begin, size_t end,
                   KernelBlock* block) {
  block->particles = end - begin;
  const size_t padded = (block->particles + KernelBlock::kLanePadding - 1) /
                        KernelBlock::kLanePadding * KernelBlock::kLanePadding;
  for (auto& plane : block->pose) plane.resize(padded);
  for (auto& plane : block->rotation) plane.resize(padded);
  block->cell.resize(padded);
  for (size_t lane = 0; lane < padded; ++lane) {
    const uint32_t particle = batch.order[begin + std::min(lane, block->particles - 1)];
    const Pose& pose = (*batch.poses)[particle];
    const Eigen::Matrix3d to_camera = pose.linear().transpose();
    const Eigen::Vector3d t = -(to_camera * pose.translation());
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        block->pose[3 * r + c][lane] = to_camera(r, c);
        block->rotation[3 * r + c][lane] = static_cast<float>(to_camera(r, c));
      }
      block->pose[9 + r][lane] = t[r];
    }
    block->cell[lane] = static_cast<int32_t>(
        std::lower_bound(cells.begin(), cells.end(), batch.cell[particle]) - cells.begin());
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
  k.max_radius2 = static_cast<float>(camera.maxPlaneRadius2());
  k.distortion = static_cast<int>(camera.distortion);
  for (int i = 0; i < 8; ++i) k.k[i] = static_cast<float>(camera.coefficients[i]);
  const CameraModel::View& v = camera.view;
  const Eigen::Vector3d planes[] = {
      {1, 0, -v.x_min}, {-1, 0, v.x_max}, {0, 1, -v.y_min}, {0, -1, v.y_max}};
  for (int i = 0; i < 4; ++i)
    Eigen::Map<Eigen::Vector3f>(k.plane[i]) = planes[i].normalized().cast<float>();
  return k;
}

/// Number of visible samples of the block's segments, summed over its particles.
uint64_t countParticleSamples(const KernelBlock& block) {
  std::vector<uint64_t> of_cell(block.cells);
  for (size_t i = 0; i < block.seen.size(); ++i)
    of_cell[i % block.cells] += std::bitset<16>(block.seen[i] & 0xffffu).count();
  uint64_t total = 0;
  for (size_t p = 0; p < block.particles; ++p) total += of_cell[block.cell[p]];
  return total;
}

/// Scores particles [begin, end) of the batch's order.
/// @return number of particle-samples evaluated.
uint64_t scoreRange(const Batch& batch, size_t begin, size_t end, std::vector<PoseScore>* scores) {
  std::vector<uint32_t> cells;
  for (size_t i = begin; i < end; ++i) cells.push_back(batch.cell[batch.order[i]]);
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  KernelBlock block;
  fillSegments(batch, cells, coneOf(batch, begin, end), &block);
  fillParticles(batch, cells, begin, end, &block);
  const LikelihoodFrame& frame = *batch.frame;
  const ScoreTable& t = *batch.table;
  const KernelTable table{t.pairs(),      t.stride(), t.rows(),  t.bins(),
                          t.hasIgnored(), t.scale(),  t.offset()};
  const LikelihoodParameters& p = frame.params;
  const KernelLineRule rule{p.model == LikelihoodModel::kPaper,
                            static_cast<float>(1 / p.line_saturation),
                            p.border_fade > 0 ? static_cast<float>(1 / p.border_fade) : 1e9f,
                            static_cast<float>(spacingScale(frame))};
  std::vector<KernelResult> results(block.particles);
  runKernel(block, kernelCamera(frame.camera), table, rule, results.data());
  for (size_t i = begin; i < end; ++i) {
    const KernelResult& r = results[i - begin];
    (*scores)[batch.order[i]] = {combineLines(p, r.line_sum, r.line_count), r.sample_weight,
                                 r.line_count};
  }
  return countParticleSamples(block);
}

/// Scores all particles of a batch with complete order and cells.
/// @return number of particle-samples evaluated.
uint64_t scoreAll(const Batch& batch, std::vector<PoseScore>* scores) {
  // The particles of a large block share more of the table in the caches. Every thread should get
  // at least two blocks.
  const size_t n = batch.order.size(), lanes = KernelBlock::kLanePadding;
  const size_t wanted = n / (2 * static_cast<size_t>(tbb::this_task_arena::max_concurrency()));
  const size_t size = std::clamp((wanted + lanes - 1) / lanes * lanes, size_t{64}, size_t{256});
  std::vector<uint64_t> evaluated((n + size - 1) / size);
  tbb::parallel_for(size_t{0}, evaluated.size(), [&](size_t r) {
    evaluated[r] = scoreRange(batch, r * size, std::min(n, (r + 1) * size), scores);
  });
  return std::accumulate(evaluated.begin(), evaluated.end(), uint64_t{0});
}

}  // namespace

CpuBackend::CpuBackend(std::shared_ptr<const Visibility> visibility)
    : visibility_(std::move(visibility)) {}

std::string CpuBackend::name() const { return std::string("cpu ") + kernelTargetName(); }

std::vector<PoseScore> CpuBackend::evaluate(const LikelihoodFrame& frame,
                                            const std::vector<Pose>& camera_poses) const {
  checkLikelihoodInput(frame, camera_poses);
  const size_t n = camera_poses.size();
  Batch batch{&frame,
              frame.tableHere(),
              &camera_poses,
              std::vector<uint32_t>(n),
              std::vector<uint32_t>(n),
              {},
              {}};
  std::iota(batch.order.begin(), batch.order.end(), 0u);
  std::vector<CellKey> key(n);
  for (size_t i = 0; i < n; ++i) key[i] = visibility_->cellOf(camera_poses[i].translation());
  std::sort(batch.order.begin(), batch.order.end(),
            [&](uint32_t a, uint32_t b) { return key[a] == key[b] ? a < b : key[a] < key[b]; });
  std::vector<uint32_t> first_of_cell;
  for (size_t i = 0; i < n; ++i) {
    const uint32_t particle = batch.order[i];
    if (i == 0 || !(key[first_of_cell.back()] == key[particle])) first_of_cell.push_back(particle);
    batch.cell[particle] = static_cast<uint32_t>(first_of_cell.size() - 1);
  }
  batch.sets.resize(first_of_cell.size());
  tbb::parallel_for(size_t{0}, batch.sets.size(),
                    [&](size_t c) { batch.sets[c] = visibility_->cached(key[first_of_cell[c]]); });
  batch.thin(visibility_->model());
  std::vector<PoseScore> scores(n);
  last_evaluated_samples_ = scoreAll(batch, &scores);
  return scores;
}

std::vector<PoseScore> evaluateWithVisibleSet(const LikelihoodFrame& frame, const VisibleSet& set,
                                              const std::vector<Pose>& camera_poses) {
  checkLikelihoodInput(frame, camera_poses);
  const size_t n = camera_poses.size();
  Batch batch{&frame,
              frame.tableHere(),
              &camera_poses,
              std::vector<uint32_t>(n),
              std::vector<uint32_t>(n, 0u),
              {},
              {}};
  std::iota(batch.order.begin(), batch.order.end(), 0u);
  batch.sets = {std::shared_ptr<const VisibleSet>(std::shared_ptr<const void>(), &set)};
  batch.thin(*set.model);
  std::vector<PoseScore> scores(n);
  scoreAll(batch, &scores);
  return scores;
}

}  // namespace edge_mcl
