#include "edge_mcl/core/mesh/flat_rectangles.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

namespace edge_mcl {

namespace {

using Point = Eigen::Vector2d;
using Polygon = std::vector<Point>;

struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero();
};

/// The part of a convex polygon on one side of a line across an axis. @param sign 1: above `limit`
Polygon cut(const Polygon& polygon, int axis, double limit, double sign) {
  Polygon result;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double of_a = sign * (a[axis] - limit), of_b = sign * (b[axis] - limit);
    if (of_a >= 0) result.push_back(a);
    if ((of_a > 0 && of_b < 0) || (of_a < 0 && of_b > 0))
      result.push_back(a + (b - a) * (of_a / (of_a - of_b)));
  }
  return result;
}

double areaOf(const Polygon& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * std::abs(twice);
}

/// Cells of a plane, and which of them the triangles cover.
class Grid {
 public:
  Grid(const std::vector<Polygon>& triangles, double cell) {
    Point low = triangles[0][0], high = low;
    for (const Polygon& t : triangles)
      for (const Point& p : t) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    // A plane of more than 50 x 50 m gets larger cells. A model in centimetres would take minutes.
    constexpr double kMostCells = 2.5e5;
    const Point extent = high - low;
    cell = std::max(cell, std::sqrt(extent.x() * extent.y() / kMostCells));
    low_ = low;
    for (int k = 0; k < 2; ++k) {
      count_[k] = std::max(1, static_cast<int>(std::floor(extent[k] / cell)));
      size_[k] = extent[k] / count_[k];
    }
    std::vector<Cover> covers(static_cast<size_t>(count_[0]) * count_[1]);
    for (const Polygon& t : triangles) add(t, &covers);
    // Where triangles overlap, the sum of their areas may make up for a gap, so such a cell does
    // not count. Where the sum is right by chance, the points tell.
    const double whole = size_[0] * size_[1];
    const double rounding = std::min(1e-4 * whole, 1e-6);  // m^2: a square millimetre
    covered_.reserve(covers.size());
    for (const Cover& c : covers)
      covered_.push_back(std::abs(c.area - whole) <= rounding && c.points == 0xffff);
  }

  int columns() const { return count_[0]; }
  int rows() const { return count_[1]; }
  double cellArea() const { return size_[0] * size_[1]; }
  uint8_t& covered(int column, int row) {
    return covered_[static_cast<size_t>(row) * count_[0] + column];
  }
  Point corner(int column, int row) const {
    return low_ + Point(column * size_[0], row * size_[1]);
  }

 private:
  int cellOf(double value, int axis) const {
    return std::clamp(static_cast<int>((value - low_[axis]) / size_[axis]), 0, count_[axis] - 1);
  }
  /// What the triangles cover of a cell: the sum of their areas, and 4 x 4 points of the cell.
  struct Cover {
    float area = 0;
    uint16_t points = 0;
  };
  void addTo(Cover* cover, const Polygon& part, const Point& corner) const {
    constexpr int kSide = 4;
    constexpr double kOnEdge = 1e-9;  // m^2; a point between two triangles belongs to both
    const double area = areaOf(part);
    cover->area += static_cast<float>(area);
    if (area >= (1 - 1e-9) * size_[0] * size_[1]) {
      cover->points = 0xffff;
      return;
    }
    Point low = part[0], high = part[0];
    for (const Point& p : part) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    for (int i = 0; i < kSide * kSide; ++i) {
      const int column = i % kSide, row = i / kSide;
      const Point p =
          corner + Point((column + 0.5) * size_[0] / kSide, (row + 0.5) * size_[1] / kSide);
      if (p.x() < low.x() - kOnEdge || p.x() > high.x() + kOnEdge || p.y() < low.y() - kOnEdge ||
          p.y() > high.y() + kOnEdge)
        continue;
      bool left = true, right = true;
      for (size_t k = 0; k < part.size(); ++k) {
        const Point side = part[(k + 1) % part.size()] - part[k], to = p - part[k];
        const double turn = side.x() * to.y() - side.y() * to.x();
        left = left && turn >= -kOnEdge;
        right = right && turn <= kOnEdge;
      }
      if (left || right) cover->points |= static_cast<uint16_t>(1u << i);
    }
  }
  void add(const Polygon& triangle, std::vector<Cover>* covers) const {
    const auto range = [&](const Polygon& p, int axis) {
      const auto by = [&](const Point& a, const Point& b) { return a[axis] < b[axis]; };
      const auto [low, high] = std::minmax_element(p.begin(), p.end(), by);
      return std::make_pair(cellOf((*low)[axis], axis), cellOf((*high)[axis], axis));
    };
    const auto [first_row, last_row] = range(triangle, 1);
    for (int row = first_row; row <= last_row; ++row) {
      const Polygon strip =
          cut(cut(triangle, 1, low_[1] + row * size_[1], 1), 1, low_[1] + (row + 1) * size_[1], -1);
      if (strip.size() < 3) continue;
      const auto [first, last] = range(strip, 0);
      for (int column = first; column <= last; ++column) {
        const Polygon part = cut(cut(strip, 0, low_[0] + column * size_[0], 1), 0,
                                 low_[0] + (column + 1) * size_[0], -1);
        if (part.size() >= 3)
          addTo(&(*covers)[static_cast<size_t>(row) * count_[0] + column], part,
                corner(column, row));
      }
    }
  }

  Point low_ = Point::Zero();
  int count_[2] = {1, 1};
  double size_[2] = {0, 0};
  std::vector<uint8_t> covered_;
};

/// Cells from the first to before the last.
struct CellRange {
  int column0 = 0, row0 = 0, column1 = 0, row1 = 0;
  int64_t cells() const { return static_cast<int64_t>(column1 - column0) * (row1 - row0); }
};

/// The largest rectangle of covered cells, row by row: the heights of the covered columns above a
/// row are a histogram, and a stack finds the largest rectangle under it.
CellRange largest(Grid* grid, const CellRange& within) {
  CellRange best;
  const int width = within.column1 - within.column0;
  std::vector<int> height(static_cast<size_t>(width) + 1, 0);
  std::vector<int> stack;
  for (int row = within.row0; row < within.row1; ++row) {
    for (int i = 0; i < width; ++i)
      height[i] = grid->covered(within.column0 + i, row) ? height[i] + 1 : 0;
    stack.clear();
    for (int i = 0; i <= width; ++i) {
      while (!stack.empty() && height[stack.back()] >= height[i]) {
        const int tall = height[stack.back()];
        stack.pop_back();
        const int begin = stack.empty() ? 0 : stack.back() + 1;
        const CellRange found{within.column0 + begin, row + 1 - tall, within.column0 + i, row + 1};
        if (found.cells() > best.cells()) best = found;
      }
      stack.push_back(i);
    }
  }
  return best;
}

/// Bounds of the covered cells that are connected to one, which are marked in `seen`.
/// @param count output: number of these cells
CellRange component(Grid* grid, int column, int row, std::vector<uint8_t>* seen, int64_t* count) {
  *count = 0;
  CellRange range{column, row, column + 1, row + 1};
  std::vector<std::pair<int, int>> open{{column, row}};
  const auto visit = [&](int c, int r) {
    if (c < 0 || r < 0 || c >= grid->columns() || r >= grid->rows() || !grid->covered(c, r)) return;
    uint8_t& mark = (*seen)[static_cast<size_t>(r) * grid->columns() + c];
    if (mark) return;
    mark = 1;
    open.emplace_back(c, r);
  };
  (*seen)[static_cast<size_t>(row) * grid->columns() + column] = 1;
  while (!open.empty()) {
    const auto [c, r] = open.back();
    open.pop_back();
    ++*count;
    range = {std::min(range.column0, c), std::min(range.row0, r), std::max(range.column1, c + 1),
             std::max(range.row1, r + 1)};
    visit(c - 1, r);
    visit(c + 1, r);
    visit(c, r - 1);
    visit(c, r + 1);
  }
  return range;
}

/// @param cell size of the cells, m.
void addRectangles(const Plane& plane, const std::vector<Polygon>& triangles, double cell,
                   double least, std::vector<Rectangle>* result) {
  constexpr int kMost = 16;  // of one connected part; the largest come first
  Grid grid(triangles, cell);
  std::vector<uint8_t> seen(static_cast<size_t>(grid.columns()) * grid.rows(), 0);
  for (int row = 0; row < grid.rows(); ++row)
    for (int column = 0; column < grid.columns(); ++column) {
      if (!grid.covered(column, row) || seen[static_cast<size_t>(row) * grid.columns() + column])
        continue;
      int64_t left = 0;
      const CellRange range = component(&grid, column, row, &seen, &left);
      const auto is_small = [&](int64_t cells) {
        return static_cast<double>(cells) * grid.cellArea() < least;
      };
      for (int k = 0; k < kMost && !is_small(left); ++k) {
        const CellRange found = largest(&grid, range);
        if (is_small(found.cells())) break;
        left -= found.cells();
        Rectangle rectangle;
        const std::pair<int, int> corners[] = {{found.column0, found.row0},
                                               {found.column1, found.row0},
                                               {found.column1, found.row1},
                                               {found.column0, found.row1}};
        for (int i = 0; i < 4; ++i) {
          const Point at = grid.corner(corners[i].first, corners[i].second);
          rectangle[i] = plane.origin + at.x() * plane.u + at.y() * plane.v;
        }
        result->push_back(rectangle);
        for (int r = found.row0; r < found.row1; ++r)
          for (int c = found.column0; c < found.column1; ++c) grid.covered(c, r) = 0;
      }
    }
}

}  // namespace

namespace {

/// Corners and normals of the triangles of a mesh, in double precision.
struct Triangles {
  const MeshModel& mesh;

  Eigen::Vector3d corner(uint32_t t, int k) const {
    return mesh.vertices[mesh.triangles[t][k]].cast<double>();
  }
  /// Its length is the area.
  Eigen::Vector3d normal(uint32_t t) const {
    return 0.5 * (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0));
  }
};

/// Numbers of the triangles by their plane: normal in thousandths, distance from the origin in
/// millimetres.
std::vector<std::vector<uint32_t>> byPlane(const Triangles& all) {
  using Key = std::tuple<int64_t, int64_t, int64_t, int64_t>;
  std::map<Key, std::vector<uint32_t>> planes;
  for (uint32_t t = 0; t < all.mesh.triangles.size(); ++t) {
    Eigen::Vector3d normal = all.normal(t).normalized();
    int axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    if (normal[axis] < 0) normal = -normal;
    const auto rounded = [](double value) { return std::llround(1000 * value); };
    planes[{rounded(normal.x()), rounded(normal.y()), rounded(normal.z()),
            rounded(normal.dot(all.corner(t, 0)))}]
        .push_back(t);
  }
  std::vector<std::vector<uint32_t>> result;
  result.reserve(planes.size());
  for (auto& [key, members] : planes) result.push_back(std::move(members));
  return result;
}

/// Plane of a triangle. Its u axis is a side at the angle closest to a right one: of half a
/// rectangle not the diagonal.
Plane planeOf(const Triangles& all, uint32_t t) {
  Plane plane;
  plane.normal = all.normal(t).normalized();
  plane.origin = all.corner(t, 0);
  double best = -1;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d side = (all.corner(t, (k + 1) % 3) - all.corner(t, k)).normalized();
    const Eigen::Vector3d next =
        (all.corner(t, (k + 2) % 3) - all.corner(t, (k + 1) % 3)).normalized();
    const double square = 1 - std::abs(side.dot(next));
    if (square <= best) continue;
    best = square;
    plane.u = side;
  }
  plane.v = plane.normal.cross(plane.u);
  return plane;
}

/// Size of the cells, m. A smaller one than a decimetre finds little more. A model with a huge
/// surface, such as one whose unit is wrong, gets larger cells, so that there are at most 20
/// million, which take some seconds.
double cellSize(const Triangles& all) {
  constexpr double kFinest = 0.1, kMostCells = 2e7;
  double area = 0;
  for (uint32_t t = 0; t < all.mesh.triangles.size(); ++t) area += all.normal(t).norm();
  return std::max(kFinest, std::sqrt(area / kMostCells));
}

std::vector<Rectangle> rectanglesOf(const Triangles& all, const std::vector<uint32_t>& members,
                                    double cell, double least) {
  std::vector<Rectangle> result;
  double area = 0;
  for (const uint32_t t : members) area += all.normal(t).norm();
  if (area < least) return result;
  const uint32_t widest = *std::max_element(
      members.begin(), members.end(),
      [&](uint32_t a, uint32_t b) { return all.normal(a).norm() < all.normal(b).norm(); });
  const Plane plane = planeOf(all, widest);
  std::vector<Polygon> triangles;
  for (const uint32_t t : members) {
    Polygon polygon;
    bool flat = true;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d at = all.corner(t, k) - plane.origin;
      flat = flat && std::abs(plane.normal.dot(at)) <= kFlat;
      polygon.emplace_back(plane.u.dot(at), plane.v.dot(at));
    }
    if (flat) triangles.push_back(std::move(polygon));
  }
  if (!triangles.empty()) addRectangles(plane, triangles, cell, least, &result);
  return result;
}

}  // namespace

std::vector<Rectangle> flatRectangles(const MeshModel& mesh, double least) {
  const Triangles all{mesh};
  const std::vector<std::vector<uint32_t>> planes = byPlane(all);
  const double cell = cellSize(all);
  std::vector<std::vector<Rectangle>> found(planes.size());
  tbb::parallel_for(size_t{0}, planes.size(),
                    [&](size_t k) { found[k] = rectanglesOf(all, planes[k], cell, least); });
  std::vector<Rectangle> result;
  for (const auto& of_plane : found) result.insert(result.end(), of_plane.begin(), of_plane.end());
  return result;
}

}  // namespace edge_mcl
