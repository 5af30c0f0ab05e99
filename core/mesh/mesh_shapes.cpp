#include "edge_mcl/core/mesh/mesh_shapes.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace edge_mcl {

MeshShapes findShapes(const MeshModel& mesh) {
  const auto count = static_cast<uint32_t>(mesh.triangles.size());
  std::vector<uint32_t> parent(count);
  std::iota(parent.begin(), parent.end(), uint32_t{0});
  const auto find = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  struct Edge {
    uint32_t low, high, triangle;
  };
  std::vector<Edge> edges;
  edges.reserve(size_t{3} * count);
  for (uint32_t t = 0; t < count; ++t)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = mesh.triangles[t].at(k), b = mesh.triangles[t].at((k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), t});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  for (size_t i = 0, j = 0; i < edges.size(); i = j) {
    while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high) ++j;
    if (j - i == 2) parent[find(edges[i].triangle)] = find(edges[i + 1].triangle);
  }
  constexpr uint32_t kNone = 0xffffffffu;
  std::vector<uint32_t> number(count, kNone);  // of the shape of a root
  MeshShapes shapes;
  shapes.of_triangle.reserve(count);
  for (uint32_t t = 0; t < count; ++t) {
    uint32_t& shape = number[find(t)];
    if (shape == kNone) {
      shape = static_cast<uint32_t>(shapes.box.size());
      shapes.box.emplace_back();
    }
    for (const uint32_t v : mesh.triangles[t]) shapes.box[shape].extend(mesh.vertices[v]);
    shapes.of_triangle.push_back(shape);
  }
  return shapes;
}

}  // namespace edge_mcl
