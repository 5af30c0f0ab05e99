#include "edge_mcl/core/mesh/mesh_model.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

using Index = uint32_t;

/// Maps every vertex to the first vertex with exactly its coordinates.
std::vector<Index> exactDuplicates(const std::vector<Eigen::Vector3f>& vertices) {
  std::vector<Index> order(vertices.size());
  std::iota(order.begin(), order.end(), Index{0});
  const auto less = [&](Index a, Index b) {
    const auto &p = vertices[a], &q = vertices[b];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    if (p.z() != q.z()) return p.z() < q.z();
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<Index> first(vertices.size());
  for (size_t i = 0; i < order.size(); ++i)
    first[order[i]] =
        i > 0 && vertices[order[i]] == vertices[order[i - 1]] ? first[order[i - 1]] : order[i];
  return first;
}

struct Cell {
  int64_t x, y, z;
  bool operator==(const Cell& o) const { return x == o.x && y == o.y && z == o.z; }
};
struct CellHash {
  size_t operator()(const Cell& c) const {
    return static_cast<size_t>(c.x * 73856093LL ^ c.y * 19349663LL ^ c.z * 83492791LL);
  }
};

/// Maps every vertex to a representative within the tolerance. The first vertex at a place
/// represents the later ones.
std::vector<Index> weldMap(const std::vector<Eigen::Vector3f>& vertices, double tolerance) {
  std::vector<Index> representative = exactDuplicates(vertices);
  if (tolerance <= 0) return representative;
  const double cell_size = 2 * tolerance;
  std::unordered_multimap<Cell, Index, CellHash> grid;
  grid.reserve(vertices.size() / 2 + 16);
  for (Index i = 0; i < vertices.size(); ++i) {
    if (representative[i] != i) continue;
    const Eigen::Vector3d scaled = vertices[i].cast<double>() / cell_size;
    const Cell home{static_cast<int64_t>(std::floor(scaled.x())),
                    static_cast<int64_t>(std::floor(scaled.y())),
                    static_cast<int64_t>(std::floor(scaled.z()))};
    // A ball with a radius of half a cell touches the home cell and, on each axis, only the nearer
    // neighbour.
    const auto side = [](double s) { return s - std::floor(s) < 0.5 ? -1 : 1; };
    const int sx = side(scaled.x()), sy = side(scaled.y()), sz = side(scaled.z());
    Index found = i;
    for (int corner = 0; corner < 8 && found == i; ++corner) {
      const Cell cell{home.x + (corner & 1 ? sx : 0), home.y + (corner & 2 ? sy : 0),
                      home.z + (corner & 4 ? sz : 0)};
      const auto range = grid.equal_range(cell);
      for (auto it = range.first; it != range.second; ++it)
        if ((vertices[it->second] - vertices[i]).norm() <= tolerance) {
          found = it->second;
          break;
        }
    }
    representative[i] = found;
    if (found == i) grid.emplace(home, i);
  }
  for (Index i = 0; i < vertices.size(); ++i) representative[i] = representative[representative[i]];
  return representative;
}

void requireSaneVertices(const MeshSoup& soup, const std::string& origin) {
  constexpr float kAbsurd = 1e6f;
  for (size_t i = 0; i < soup.vertices.size(); ++i) {
    const auto& v = soup.vertices[i];
    if (!v.allFinite())
      throw InputError(origin + ": vertex " + std::to_string(i) +
                       " has a coordinate that is not finite");
    if (v.cwiseAbs().maxCoeff() > kAbsurd)
      throw InputError(origin + ": vertex " + std::to_string(i) +
                       " is more than 1000 km from the origin (is map.scale right?)");
  }
}

}  // namespace

MeshModel weldMesh(MeshSoup soup, double weld_tolerance, const std::string& origin) {
  requireSaneVertices(soup, origin);
  MeshModel mesh;
  mesh.report.vertices_read = soup.vertices.size();
  mesh.material_count = soup.material_count;
  mesh.material_colors = std::move(soup.material_colors);
  mesh.material_colors.resize(mesh.material_count, Eigen::Vector3f::Constant(0.7f));
  const std::vector<Index> representative = weldMap(soup.vertices, weld_tolerance);

  constexpr Index kUnused = 0xffffffffu;
  std::vector<Index> compact(soup.vertices.size(), kUnused);
  const auto use = [&](Index old) {
    const Index r = representative[old];
    if (compact[r] == kUnused) {
      compact[r] = static_cast<Index>(mesh.vertices.size());
      mesh.vertices.push_back(soup.vertices[r]);
    }
    return compact[r];
  };

  struct Keyed {
    std::array<Index, 3> sorted;
    Index triangle;
  };
  std::vector<Keyed> keyed;
  keyed.reserve(soup.triangles.size());
  for (size_t t = 0; t < soup.triangles.size(); ++t) {
    std::array<Index, 3> key{};
    for (int k = 0; k < 3; ++k) key[k] = representative[soup.triangles[t][k]];
    const auto &a = soup.vertices[key[0]], &b = soup.vertices[key[1]], &c = soup.vertices[key[2]];
    const double area2 = (b - a).cast<double>().cross((c - a).cast<double>()).norm();
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm(), 1e-30f});
    // A sliver whose height is below the weld tolerance has no usable normal.
    if (key[0] == key[1] || key[1] == key[2] || key[2] == key[0] ||
        area2 / longest <= std::max(weld_tolerance, 1e-9)) {
      ++mesh.report.degenerate_triangles;
      continue;
    }
    std::sort(key.begin(), key.end());
    keyed.push_back({key, static_cast<Index>(t)});
  }
  std::vector<Keyed> by_key = keyed;
  std::sort(by_key.begin(), by_key.end(), [](const Keyed& a, const Keyed& b) {
    return a.sorted != b.sorted ? a.sorted < b.sorted : a.triangle < b.triangle;
  });
  std::vector<bool> duplicate(soup.triangles.size(), false);
  for (size_t i = 1; i < by_key.size(); ++i)
    if (by_key[i].sorted == by_key[i - 1].sorted) duplicate[by_key[i].triangle] = true;
  for (const Keyed& k : keyed) {
    if (duplicate[k.triangle]) {
      ++mesh.report.duplicate_triangles;
      continue;
    }
    const auto& t = soup.triangles[k.triangle];
    mesh.triangles.push_back({use(t[0]), use(t[1]), use(t[2])});
    mesh.triangle_material.push_back(soup.triangle_material[k.triangle]);
    if (!soup.hides_only.empty()) mesh.hides_only.push_back(soup.hides_only[k.triangle]);
  }
  for (const auto& line : soup.lines) {
    if (representative[line[0]] == representative[line[1]])
      ++mesh.report.zero_length_lines;
    else
      mesh.lines.push_back({use(line[0]), use(line[1])});
  }
  if (mesh.triangles.empty() && mesh.lines.empty())
    throw InputError(origin + ": the model has no usable face or line element");

  mesh.lowest = mesh.highest = mesh.vertices.front();
  for (const auto& v : mesh.vertices) {
    mesh.lowest = mesh.lowest.cwiseMin(v);
    mesh.highest = mesh.highest.cwiseMax(v);
  }
  return mesh;
}

}  // namespace edge_mcl
