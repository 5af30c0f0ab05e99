#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/mesh/embree.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <numeric>

namespace edge_mcl {

/// Visible sets by cell. The least recently used cell is dropped first.
struct Visibility::Cache {
  struct Entry {
    std::shared_ptr<const VisibleSet> set;
    std::list<CellKey>::iterator age;
  };
  mutable std::mutex mutex;
  std::map<CellKey, Entry> cells;
  std::list<CellKey> by_age;  // most recently used first
  CacheStatistics statistics;
};

namespace {

/// Rays from one position to many points, traced in packets. Rays that end side by side share most
/// of their way through the scene.
class RayPacket {
 public:
  RayPacket(RTCScene scene, const Eigen::Vector3f& from) : scene_(scene), from_(from) {}

  /// Adds the ray to a point.
  /// @param tolerance surfaces closer than this to the point do not hide it, metres.
  /// @param bit number of the bit in `*visible` that is cleared, now or later, when a surface hides
  ///   the point.
  void add(const Eigen::Vector3f& point, float tolerance, uint32_t bit, uint16_t* visible) {
    const Eigen::Vector3f direction = point - from_;
    const float distance = direction.norm();
    if (distance <= tolerance) return;
    const int i = count_++;
    rays_.org_x[i] = from_.x();
    rays_.org_y[i] = from_.y();
    rays_.org_z[i] = from_.z();
    rays_.dir_x[i] = direction.x() / distance;
    rays_.dir_y[i] = direction.y() / distance;
    rays_.dir_z[i] = direction.z() / distance;
    rays_.tnear[i] = 0;
    rays_.tfar[i] = distance - tolerance;
    rays_.mask[i] = 0xffffffffu;
    targets_[i] = {visible, static_cast<uint16_t>(1u << bit)};
    if (count_ == kSize) trace();
  }

  /// Traces the rays that are waiting.
  void trace() {
    alignas(64) int valid[kSize];
    for (int i = 0; i < kSize; ++i) valid[i] = i < count_ ? -1 : 0;
    embree::occluded16(valid, scene_, &rays_);
    for (int i = 0; i < count_; ++i)
      if (rays_.tfar[i] < 0) *targets_[i].visible &= static_cast<uint16_t>(~targets_[i].bit);
    count_ = 0;
  }

 private:
  static constexpr int kSize = 16;
  struct Target {
    uint16_t* visible;
    uint16_t bit;
  };
  RTCScene scene_;
  Eigen::Vector3f from_;
  RTCRay16 rays_{};
  Target targets_[kSize];
  int count_ = 0;
};

double automaticCellSize(const MeshModel& mesh) {
  return std::clamp(0.02 * mesh.diagonal(), 0.02, 0.10);
}
/// The faces of a scan lie beside its lines, by the noise of the scan and by the size of the faces
/// (5 cm by default).
constexpr double kScanTolerance = 0.08;  // m

double automaticTolerance(const MeshModel& mesh) {
  const bool is_scan =
      !mesh.hides_only.empty() && std::all_of(mesh.hides_only.begin(), mesh.hides_only.end(),
                                              [](bool hides_only) { return hides_only; });
  return is_scan ? kScanTolerance : std::clamp(0.002 * mesh.diagonal(), 1e-4, 0.01);
}

/// Weight of a line by the direction of its faces, see VisibleSet::facingWeight(). It is the
/// largest apparent width per depth of the visible faces at the line, as a share of the width that
/// counts as full view. In the cross-section at the line, two faces on the same side of it hide
/// each other. The face closer to the direction of the eye is in front.
float facingWeight(const EdgeLine& line, const Eigen::Vector3f& at, const Eigen::Vector3f& eye) {
  constexpr float kFullView = 0.17f;  // sine of 10 degrees
  const bool has_a = !line.into_a.isZero(), has_b = !line.into_b.isZero();
  if (line.kind == EdgeKind::kContour || (!has_a && !has_b)) return 1;
  const Eigen::Vector3f tangent = line.tangent();
  Eigen::Vector3f to_eye = eye - at;
  to_eye -= tangent * tangent.dot(to_eye);
  if (to_eye.norm() < 1e-6f) return 1;
  to_eye.normalize();
  const Eigen::Vector3f sideways = tangent.cross(to_eye);
  const float sin_a = line.into_a.dot(sideways), sin_b = line.into_b.dot(sideways);
  float width = 0;
  if (!has_b)
    width = std::abs(sin_a);
  else if (!has_a)
    width = std::abs(sin_b);
  else if ((sin_a > 0) != (sin_b > 0))
    width = std::max(std::abs(sin_a), std::abs(sin_b));
  else
    width = std::abs(line.into_a.dot(to_eye) > line.into_b.dot(to_eye) ? sin_a : sin_b);
  return std::min(1.0f, width / kFullView);
}

}  // namespace

Visibility::Visibility(const MeshModel& mesh, const EdgeModel& model,
                       const VisibilityParameters& params)
    : model_(model),
      params_(params),
      cell_size_(params.cell_size > 0 ? params.cell_size : automaticCellSize(mesh)),
      tolerance_(params.occlusion_tolerance > 0 ? params.occlusion_tolerance
                                                : automaticTolerance(mesh)),
      tolerance_of_lines_(params.occlusion_tolerance > 0 || mesh.hides_only.empty()
                              ? tolerance_
                              : std::max(tolerance_, kScanTolerance)),
      scene_(mesh.triangles.empty() ? nullptr
                                    : std::make_unique<RayScene>(mesh, RayScene::Rays::kRobust)),
      large_faces_(mesh),
      tree_(model),
      cache_(std::make_unique<Cache>()) {}

Visibility::~Visibility() = default;

bool ViewCone::touches(const Eigen::Vector3f& centre, float radius) const {
  const float distance = centre.norm();
  if (distance <= radius) return true;
  const float most = angle + std::asin(radius / distance);
  return most >= static_cast<float>(M_PI) || axis.dot(centre) >= distance * std::cos(most);
}

VisibleSet Visibility::exact(const Eigen::Vector3d& position, uint32_t thinning,
                             const ViewCone& cone) const {
  const Eigen::Vector3f eye = position.cast<float>();
  const auto tolerance = static_cast<float>(tolerance_of_lines_);  // the larger one
  return tested(eye, thinning, cone, tree_.find([&](const Box& box) {
    return cone.touches(box.centre - eye, box.half.norm()) &&
           !large_faces_.hide(eye, box.centre, box.half, tolerance);
  }));
}

VisibleSet Visibility::exhaustive(const Eigen::Vector3d& position) const {
  std::vector<uint32_t> all(model_.segments.size());
  std::iota(all.begin(), all.end(), 0u);
  return tested(position.cast<float>(), 1, {}, all);
}

VisibleSet Visibility::tested(const Eigen::Vector3f& eye, uint32_t thinning, const ViewCone& cone,
                              const std::vector<uint32_t>& candidates) const {
  std::vector<VisibleSet::Segment> asked;
  for (const uint32_t k : candidates) {
    const EdgeSegment& segment = model_.segments[k];
    if (!cone.touches(segment.centre - eye, segment.radius)) continue;
    const EdgeLine& line = model_.lines[segment.line];
    if (line.kind == EdgeKind::kContour) {
      const Eigen::Vector3f to_eye = eye - line.start;
      if ((line.normal_a.dot(to_eye) > 0) == (line.normal_b.dot(to_eye) > 0)) continue;
    }
    VisibleSet::Segment seen;
    seen.index = k;
    seen.samples = usedSamples(segment, thinning);
    if (seen.samples) asked.push_back(seen);
  }
  if (scene_) removeHidden(eye, &asked);

  VisibleSet result;
  result.model = &model_;
  for (VisibleSet::Segment& seen : asked) {
    if (!seen.samples) continue;
    const EdgeSegment& segment = model_.segments[seen.index];
    const EdgeLine& line = model_.lines[segment.line];
    result.sample_count += std::bitset<16>(seen.samples).count();
    seen.facing =
        static_cast<uint16_t>(std::lround(65535 * facingWeight(line, segment.centre, eye)));
    if (result.segments.empty() || result.line(result.segments.back()).group != line.group)
      ++result.group_count;
    result.segments.push_back(seen);
  }
  return result;
}

void Visibility::removeHidden(const Eigen::Vector3f& eye,
                              std::vector<VisibleSet::Segment>* segments) const {
  RayPacket packet(scene_->get(), eye);
  for (VisibleSet::Segment& seen : *segments) {
    const EdgeSegment& segment = model_.segments[seen.index];
    const bool is_explicit = model_.lines[segment.line].kind == EdgeKind::kLine;
    const auto tolerance = static_cast<float>(is_explicit ? tolerance_of_lines_ : tolerance_);
    // A copy, because the packet clears bits of seen.samples during this loop.
    const uint16_t asked = seen.samples;
    for (uint32_t i = 0; i < segment.sample_count; ++i)
      if (asked >> i & 1u)
        packet.add(model_.samplePosition(segment, i).cast<float>(), tolerance, i, &seen.samples);
  }
  packet.trace();
}

CellKey Visibility::cellOf(const Eigen::Vector3d& position) const {
  const auto index = [&](double v) { return static_cast<int>(std::floor(v / cell_size_)); };
  return {index(position.x()), index(position.y()), index(position.z())};
}

Eigen::Vector3d Visibility::cellCentre(const CellKey& cell) const {
  return cell_size_ * Eigen::Vector3d(cell.x + 0.5, cell.y + 0.5, cell.z + 0.5);
}

std::shared_ptr<const VisibleSet> Visibility::cached(const CellKey& cell) const {
  Cache& cache = *cache_;
  {
    std::unique_lock<std::mutex> lock(cache.mutex);
    auto it = cache.cells.find(cell);
    if (it != cache.cells.end() && it->second.set) {
      ++cache.statistics.hits;
      cache.by_age.splice(cache.by_age.begin(), cache.by_age, it->second.age);
      return it->second.set;
    }
  }
  // Two threads that miss a cell at the same time both compute it. Waiting for each other could
  // deadlock a work-stealing scheduler.
  auto set = std::make_shared<const VisibleSet>(exact(cellCentre(cell)));
  std::unique_lock<std::mutex> lock(cache.mutex);
  ++cache.statistics.misses;
  auto [it, fresh] = cache.cells.try_emplace(cell);
  if (!fresh) return it->second.set;
  cache.by_age.push_front(cell);
  it->second = {set, cache.by_age.begin()};
  cache.statistics.bytes += set->bytes();
  // The newest cell is kept whatever its size, since somebody asks for it now.
  while (static_cast<double>(cache.statistics.bytes) > 1e6 * params_.cache_megabytes &&
         cache.cells.size() > 1) {
    const auto oldest = cache.cells.find(cache.by_age.back());
    cache.statistics.bytes -= oldest->second.set->bytes();
    cache.cells.erase(oldest);
    cache.by_age.pop_back();
    ++cache.statistics.dropped;
  }
  return set;
}

Visibility::CacheStatistics Visibility::statistics() const {
  std::lock_guard<std::mutex> lock(cache_->mutex);
  CacheStatistics result = cache_->statistics;
  result.cells = cache_->cells.size();
  return result;
}

}  // namespace edge_mcl
