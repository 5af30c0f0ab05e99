#include "edge_mcl/mapping/face_simplification.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>

namespace edge_mcl {

MeshSoup simplifiedFaces(const std::vector<Eigen::Vector3f>& vertices,
                         const std::vector<std::array<uint32_t, 3>>& triangles, double size) {
  std::unordered_map<int64_t, uint32_t> cubes;
  std::vector<Eigen::Vector3d> sum;
  std::vector<size_t> count;
  std::vector<uint32_t> cube_of(vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i) {
    int64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key =
          key * 2097152 +
          (static_cast<int64_t>(std::floor(static_cast<double>(vertices[i][k]) / size)) + 1048576);
    const auto [it, is_new] = cubes.emplace(key, static_cast<uint32_t>(sum.size()));
    if (is_new) {
      sum.emplace_back(Eigen::Vector3d::Zero());
      count.push_back(0);
    }
    cube_of[i] = it->second;
    sum[it->second] += vertices[i].cast<double>();
    ++count[it->second];
  }
  MeshSoup soup;
  for (size_t i = 0; i < sum.size(); ++i)
    soup.vertices.push_back((sum[i] / static_cast<double>(count[i])).cast<float>());
  std::set<std::array<uint32_t, 3>> known;
  for (const auto& t : triangles) {
    const std::array<uint32_t, 3> face{cube_of[t[0]], cube_of[t[1]], cube_of[t[2]]};
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
    std::array<uint32_t, 3> sorted = face;
    std::sort(sorted.begin(), sorted.end());
    if (!known.insert(sorted).second) continue;
    soup.triangles.push_back(face);
    soup.triangle_material.push_back(0);
  }
  return soup;
}

}  // namespace edge_mcl
