#include "edge_mcl/comparison/surface_points.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

std::vector<Eigen::Vector3f> surfacePoints(const MeshModel& mesh, double spacing) {
  std::vector<Eigen::Vector3f> points;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices[triangle[0]];
    const Eigen::Vector3f ab = mesh.vertices[triangle[1]] - a, ac = mesh.vertices[triangle[2]] - a;
    const float longest = std::max({ab.norm(), ac.norm(), (ab - ac).norm()});
    const int steps = std::max(1, static_cast<int>(std::ceil(longest / spacing)));
    // A long thin triangle gets fewer points across, so that it is not denser across than along.
    const float area = ab.cross(ac).norm();
    const int across = std::clamp(static_cast<int>(std::ceil(area / longest / spacing)), 1, steps);
    const int along = steps;
    const bool ab_is_longer = ab.norm() >= ac.norm();
    for (int i = 0; i <= along; ++i) {
      for (int k = 0; k <= across; ++k) {
        float u = static_cast<float>(i) / static_cast<float>(along);
        float v = static_cast<float>(k) / static_cast<float>(across);
        v *= 1 - u;
        points.push_back(ab_is_longer ? Eigen::Vector3f(a + u * ab + v * ac)
                                      : Eigen::Vector3f(a + u * ac + v * ab));
      }
    }
  }
  return points;
}

std::vector<std::pair<Eigen::Vector2f, Eigen::Vector2f>> sectionOf(const MeshModel& mesh,
                                                                   double height) {
  std::vector<std::pair<Eigen::Vector2f, Eigen::Vector2f>> pieces;
  const auto h = static_cast<float>(height);
  for (const auto& triangle : mesh.triangles) {
    std::vector<Eigen::Vector2f> ends;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3f& a = mesh.vertices[triangle[static_cast<size_t>(i)]];
      const Eigen::Vector3f& b = mesh.vertices[triangle[static_cast<size_t>((i + 1) % 3)]];
      if ((a.z() < h) == (b.z() < h)) continue;
      const Eigen::Vector3f p = a + (h - a.z()) / (b.z() - a.z()) * (b - a);
      ends.emplace_back(p.x(), p.y());
    }
    if (ends.size() == 2) pieces.emplace_back(ends[0], ends[1]);
  }
  return pieces;
}

}  // namespace edge_mcl
