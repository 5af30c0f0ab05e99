#include "edge_mcl/audit/new_lines.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/mesh/closest_point.h"

namespace edge_mcl {

namespace {

using Eigen::Vector3d;

/// A line is explained by a model line within this distance, m, or two of its standard deviations.
constexpr double kNear = 0.04;
const double kParallel = std::cos(12 * kDegree);
constexpr double kStep = 0.04;  // m, between the places of a line that are examined
/// A marking is this near to a surface, m.
constexpr double kOnSurface = 0.04;
/// Lines this near to each other are of one object, m.
constexpr double kTogether = 0.12;

/// Pieces of the model's lines, by place.
class ModelLines {
 public:
  explicit ModelLines(const EdgeModel& edges) : edges_(edges) {
    for (uint32_t i = 0; i < edges.segments.size(); ++i)
      for (uint32_t s = 0; s < edges.segments[i].sample_count; ++s) {
        std::vector<uint32_t>& list = cells_[key(edges.samplePosition(edges.segments[i], s))];
        if (list.empty() || list.back() != edges.segments[i].line)
          list.push_back(edges.segments[i].line);
      }
  }

  bool explains(const Vector3d& point, const Vector3d& direction, double distance) const {
    for (int corner = 0; corner < 27; ++corner) {
      const Eigen::Vector3i shift(corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1);
      const auto cell = cells_.find(key(point + kCell * shift.cast<double>()));
      if (cell == cells_.end()) continue;
      for (const uint32_t i : cell->second) {
        const EdgeLine& line = edges_.lines[i];
        const Vector3d tangent = line.tangent().cast<double>();
        if (std::abs(tangent.dot(direction)) < kParallel) continue;
        const Vector3d to = point - line.start.cast<double>();
        if ((to - to.dot(tangent) * tangent).norm() < distance) return true;
      }
    }
    return false;
  }

 private:
  static constexpr double kCell = 0.1;  // m
  static uint64_t key(const Vector3d& p) {
    const auto part = [](double v) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v / kCell)) + (1 << 20)) &
             0x1fffffu;
    };
    return part(p.x()) << 42 | part(p.y()) << 21 | part(p.z());
  }
  const EdgeModel& edges_;
  std::unordered_map<uint64_t, std::vector<uint32_t>> cells_;
};

/// Smallest distance between points of two lines that are sampled.
double distanceBetween(const AuditRow& a, const AuditRow& b) {
  double least = INFINITY;
  const auto steps = static_cast<int>((a.end - a.start).norm() / kStep) + 1;
  const Vector3d way = b.end - b.start;
  for (int i = 0; i <= steps; ++i) {
    const Vector3d p = a.start + i / static_cast<double>(steps) * (a.end - a.start);
    const double along = std::clamp((p - b.start).dot(way) / way.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - b.start - along * way).norm());
  }
  return least;
}

void numberObjects(std::vector<AuditRow>* rows) {
  std::vector<size_t> parent(rows->size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  const auto find = [&](size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (size_t i = 0; i < rows->size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if ((*rows)[i].verdict == "new" && (*rows)[j].verdict == "new" && find(i) != find(j) &&
          distanceBetween((*rows)[i], (*rows)[j]) < kTogether)
        parent[find(i)] = find(j);
  std::map<size_t, int> numbers;
  for (size_t i = 0; i < rows->size(); ++i)
    if ((*rows)[i].verdict == "new")
      (*rows)[i].shape = numbers.emplace(find(i), static_cast<int>(numbers.size())).first->second;
}

}  // namespace

std::vector<AuditRow> findNewLines(const std::vector<MappedLine>& lines,
                                   const LocalizationMap& map) {
  const ModelLines model(map.edges());
  std::unique_ptr<ClosestFace> faces;
  if (!map.mesh().triangles.empty()) faces = std::make_unique<ClosestFace>(map.mesh());
  std::vector<AuditRow> rows;
  for (const MappedLine& line : lines) {
    const Vector3d way = line.end - line.start;
    const auto steps = std::max(1, static_cast<int>(way.norm() / kStep));
    const double near = std::max(kNear, 2 * line.sigma);
    int explained = 0, on_surface = 0;
    for (int i = 0; i <= steps; ++i) {
      const Vector3d p = line.start + i / static_cast<double>(steps) * way;
      explained += model.explains(p, way.normalized(), near) ? 1 : 0;
      on_surface += faces && faces->find(p, std::max(kOnSurface, near)).found ? 1 : 0;
    }
    if (2 * explained > steps) continue;
    AuditRow row;
    row.part = AuditRow::Part::kNew;
    row.start = line.start + map.mesh().origin;
    row.end = line.end + map.mesh().origin;
    row.viewpoints = static_cast<int>(line.views);
    row.shown = 1;
    row.verdict = 2 * on_surface > steps ? "marking" : "new";
    rows.push_back(row);
  }
  numberObjects(&rows);
  return rows;
}

std::vector<NewObject> newObjects(const std::vector<AuditRow>& rows) {
  std::map<int, NewObject> objects;
  for (const AuditRow& row : rows) {
    if (row.part != AuditRow::Part::kNew || row.shape < 0) continue;
    NewObject& object = objects[row.shape];
    if (object.lines++ == 0) {
      object.number = row.shape;
      object.lowest = object.highest = row.start;
    }
    for (const Vector3d& end : {row.start, row.end}) {
      object.lowest = object.lowest.cwiseMin(end);
      object.highest = object.highest.cwiseMax(end);
    }
  }
  std::vector<NewObject> list;
  for (const auto& [number, object] : objects)
    if (object.lines >= 3) list.push_back(object);
  return list;
}

}  // namespace edge_mcl
