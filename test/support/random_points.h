/// Random points, and their distances computed in the plainest way.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>

#include "edge_mcl/core/mesh/closest_point.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl::test {

using Random = std::mt19937_64;

inline double uniform(Random* random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*random);
}

inline Eigen::Vector3d anywhere(Random* random, double low = -1, double high = 1) {
  return {uniform(random, low, high), uniform(random, low, high), uniform(random, low, high)};
}

/// Distance of a point from the mesh: the smallest of its distances from all faces.
inline double plainDistance(const MeshModel& mesh, const Eigen::Vector3d& p) {
  double least = INFINITY;
  for (const auto& t : mesh.triangles)
    least = std::min(least, (closestPointOnTriangle(p, mesh.vertices[t[0]].cast<double>(),
                                                    mesh.vertices[t[1]].cast<double>(),
                                                    mesh.vertices[t[2]].cast<double>()) -
                             p)
                                .norm());
  return least;
}

}  // namespace edge_mcl::test
