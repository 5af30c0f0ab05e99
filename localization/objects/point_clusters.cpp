#include "edge_mcl/localization/objects/point_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace edge_mcl {

namespace {

constexpr int kBits = 21;
constexpr int64_t kOffset = int64_t{1} << (kBits - 1), kMask = (int64_t{1} << kBits) - 1;
constexpr double kFarthest = 5e4;  // m; the number of a voxel must fit into kBits
/// Gap between voxels of a thing that lie above one another, voxels.
constexpr int64_t kGapUpwards = 4;
/// Largest step of depth between neighbouring pixels of one surface, m: a side that is seen at 10
/// degrees from 5 m.
constexpr float kDepthGap = 0.25F;
/// See isLarge(). 1, m
constexpr int kFewestPoints = 20;
constexpr double kSmallest = 0.15;
/// Share of the points that may lie beyond either side of a box.
constexpr double kTrimmed = 0.005;

int64_t indexOf(float coordinate) {
  return static_cast<int64_t>(std::floor(static_cast<double>(coordinate) / kObjectVoxel)) + kOffset;
}
/// Voxels above one another have neighbouring keys.
int64_t keyOf(int64_t x, int64_t y, int64_t z) { return (x << 2 * kBits) | (y << kBits) | z; }
int64_t columnOf(int64_t key) { return key >> kBits; }
int64_t heightOf(int64_t key) { return key & kMask; }

/// Voxels above one another, without large gaps.
struct Run {
  int64_t column, low, high;
  size_t begin, end;  // among the voxels
};

std::vector<Run> runsOf(const std::vector<VoxelPoint>& voxels) {
  std::vector<Run> runs;
  for (size_t i = 0; i < voxels.size(); ++i) {
    const int64_t column = columnOf(voxels[i].key), height = heightOf(voxels[i].key);
    if (!runs.empty() && runs.back().column == column &&
        height <= runs.back().high + kGapUpwards + 1) {
      runs.back().high = height;
      runs.back().end = i + 1;
    } else {
      runs.push_back({column, height, height, i, i + 1});
    }
  }
  return runs;
}

/// A union-find structure whose roots are the first members.
class Groups {
 public:
  explicit Groups(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
  }
  size_t rootOf(size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(size_t a, size_t b) {
    a = rootOf(a);
    b = rootOf(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<size_t> parent_;
};

void joinNeighbours(const std::vector<Run>& runs, Groups* groups) {
  // The other half of the eight neighbours find this run themselves.
  constexpr std::array<std::array<int64_t, 2>, 4> kNeighbours{{{0, 1}, {1, -1}, {1, 0}, {1, 1}}};
  for (size_t i = 0; i < runs.size(); ++i)
    for (const auto& [x, y] : kNeighbours) {
      const int64_t column = runs[i].column + (x << kBits) + y;
      auto next = std::lower_bound(runs.begin(), runs.end(), column,
                                   [](const Run& run, int64_t c) { return run.column < c; });
      for (; next != runs.end() && next->column == column; ++next)
        if (next->low <= runs[i].high + kGapUpwards + 1 &&
            runs[i].low <= next->high + kGapUpwards + 1)
          groups->join(i, static_cast<size_t>(next - runs.begin()));
    }
}

}  // namespace

Voxels voxelsOf(const std::vector<Eigen::Vector3f>& points) {
  std::vector<std::pair<int64_t, uint32_t>> order;  // key and point
  order.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& p = points[i];
    if (p.allFinite() && p.cwiseAbs().maxCoeff() < static_cast<float>(kFarthest))
      order.emplace_back(keyOf(indexOf(p.x()), indexOf(p.y()), indexOf(p.z())),
                         static_cast<uint32_t>(i));
  }
  std::sort(order.begin(), order.end());
  Voxels voxels;
  voxels.of_point.assign(points.size(), Voxels::kNone);
  for (const auto& [key, i] : order) {
    if (voxels.list.empty() || voxels.list.back().key != key)
      voxels.list.push_back({key, Eigen::Vector3f::Zero(), 0, 0});
    VoxelPoint& joined = voxels.list.back();
    joined.point += (points[i] - joined.point) / static_cast<float>(++joined.count);
    voxels.of_point[i] = static_cast<uint32_t>(voxels.list.size() - 1);
  }
  return voxels;
}

std::vector<PointPair> neighboursOf(const std::vector<Eigen::Vector3f>& points,
                                    const CameraModel& camera, double spacing) {
  const int columns = static_cast<int>(camera.width / spacing) + 2,
            rows = static_cast<int>(camera.height / spacing) + 2;
  std::vector<uint32_t> grid(static_cast<size_t>(columns) * static_cast<size_t>(rows),
                             Voxels::kNone);
  std::vector<PointPair> pairs;
  // Points come row by row, so the left and the upper neighbour are in the grid already.
  for (size_t i = 0; i < points.size(); ++i) {
    Eigen::Vector2d pixel;
    if (!camera.project(points[i].cast<double>(), &pixel)) continue;
    const int column = static_cast<int>(std::lround(pixel.x() / spacing)),
              row = static_cast<int>(std::lround(pixel.y() / spacing));
    if (column < 0 || column >= columns || row < 0 || row >= rows) continue;
    const size_t at =
        static_cast<size_t>(row) * static_cast<size_t>(columns) + static_cast<size_t>(column);
    grid[at] = static_cast<uint32_t>(i);
    const auto join = [&](size_t other) {
      if (grid[other] != Voxels::kNone &&
          std::abs(points[grid[other]].z() - points[i].z()) < kDepthGap)
        pairs.emplace_back(grid[other], static_cast<uint32_t>(i));
    };
    if (column > 0) join(at - 1);
    if (row > 0) join(at - static_cast<size_t>(columns));
  }
  return pairs;
}

std::vector<PointCluster> clustersOf(const Voxels& of_points, const std::vector<PointPair>& pairs) {
  const std::vector<VoxelPoint>& voxels = of_points.list;
  const std::vector<Run> runs = runsOf(voxels);
  Groups groups(runs.size());
  joinNeighbours(runs, &groups);
  std::vector<size_t> run_of(voxels.size());
  for (size_t i = 0; i < runs.size(); ++i)
    std::fill(run_of.begin() + static_cast<ptrdiff_t>(runs[i].begin),
              run_of.begin() + static_cast<ptrdiff_t>(runs[i].end), i);
  for (const auto& [a, b] : pairs) {
    const uint32_t voxel_a = of_points.of_point[a], voxel_b = of_points.of_point[b];
    if (voxel_a != Voxels::kNone && voxel_b != Voxels::kNone && voxel_a != voxel_b)
      groups.join(run_of[voxel_a], run_of[voxel_b]);
  }
  std::vector<VoxelPoint> marked = voxels;
  std::vector<int> neighbours(of_points.of_point.size(), 0);
  constexpr int kSides = 4;
  for (const auto& [a, b] : pairs)
    for (const uint32_t point : {a, b})
      if (++neighbours[point] == kSides && of_points.of_point[point] != Voxels::kNone)
        ++marked[of_points.of_point[point]].inner;
  std::vector<PointCluster> clusters;
  std::vector<size_t> number(runs.size());
  for (size_t i = 0; i < runs.size(); ++i) {
    const size_t root = groups.rootOf(i);
    if (root == i) {
      number[i] = clusters.size();
      clusters.emplace_back();
    }
    PointCluster& cluster = clusters[number[root]];
    cluster.insert(cluster.end(), marked.begin() + static_cast<ptrdiff_t>(runs[i].begin),
                   marked.begin() + static_cast<ptrdiff_t>(runs[i].end));
  }
  return clusters;
}

int pointsIn(const PointCluster& cluster) {
  return std::accumulate(cluster.begin(), cluster.end(), 0,
                         [](int sum, const VoxelPoint& v) { return sum + v.count; });
}

int innerPointsIn(const PointCluster& cluster) {
  return std::accumulate(cluster.begin(), cluster.end(), 0,
                         [](int sum, const VoxelPoint& v) { return sum + v.inner; });
}

Eigen::AlignedBox3d boxOf(const PointCluster& cluster) {
  Eigen::AlignedBox3d box;
  const double trimmed = kTrimmed * pointsIn(cluster);
  std::vector<std::pair<double, int>> along(cluster.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < cluster.size(); ++i)
      along[i] = {static_cast<double>(cluster[i].point[axis]), cluster[i].count};
    std::sort(along.begin(), along.end());
    double before = 0, after = 0;
    const auto low = std::find_if(along.begin(), along.end(),
                                  [&](const auto& v) { return (before += v.second) > trimmed; });
    const auto high = std::find_if(along.rbegin(), along.rend(),
                                   [&](const auto& v) { return (after += v.second) > trimmed; });
    if (low == along.end()) return box;
    box.min()[axis] = low->first;
    box.max()[axis] = high->first;
  }
  return box;
}

bool isLarge(const PointCluster& cluster) {
  return innerPointsIn(cluster) >= kFewestPoints && boxOf(cluster).sizes().maxCoeff() >= kSmallest;
}

PointCluster joined(PointCluster a, const PointCluster& b) {
  a.insert(a.end(), b.begin(), b.end());
  std::sort(a.begin(), a.end(),
            [](const VoxelPoint& p, const VoxelPoint& q) { return p.key < q.key; });
  return a;
}

}  // namespace edge_mcl
