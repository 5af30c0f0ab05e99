#include "edge_mcl/mapping/scan_places.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace edge_mcl {

namespace {

/// Number of times that all numbers can be halved, at most `most`.
int halvings(const Eigen::Vector3i& numbers, int most) {
  int n = 0;
  while (n < most && (numbers.x() >> n) % 2 == 0 && (numbers.y() >> n) % 2 == 0 &&
         (numbers.z() >> n) % 2 == 0)
    ++n;
  return n;
}

}  // namespace

void forSpreadPlaces(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double spacing,
                     const std::function<void(const Eigen::Vector3d&)>& visit) {
  // The first places are 8 spacings apart, farther than most rooms reach.
  constexpr int kLevels = 3;
  const Eigen::Vector3d start = low + Eigen::Vector3d::Constant(spacing / 2);
  const Eigen::Vector3i count =
      ((high - start) / spacing).array().ceil().max(0).matrix().cast<int>();
  for (int level = kLevels; level >= 0; --level)
    for (int z = 0; z < count.z(); ++z)
      for (int y = 0; y < count.y(); ++y)
        for (int x = 0; x < count.x(); ++x)
          if (halvings({x, y, z}, kLevels) == level)
            visit(start + spacing * Eigen::Vector3d(x, y, z));
}

SeenSurface::Part SeenSurface::partOf(const SurfacePiece& piece) {
  constexpr float kCube = 1;  // m; rays that are 17 degrees apart hit each cube within 3.4 m
  int axis = 0;
  piece.normal.cwiseAbs().maxCoeff(&axis);
  const bool positive = piece.normal[axis] > 0;
  // The point is moved into the open, so that noise does not move a wall to the next cube.
  const Eigen::Vector3f at = (piece.point + 0.3f * piece.normal) / kCube;
  return {static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y())),
          static_cast<int>(std::floor(at.z())), 2 * axis + (positive ? 1 : 0)};
}

bool SeenSurface::add(const std::vector<SurfacePiece>& pieces) {
  constexpr double kFewNew = 0.15;  // of the parts in reach
  std::set<Part> parts;
  for (const SurfacePiece& piece : pieces)
    if (static_cast<double>(piece.distance) < far_) parts.insert(partOf(piece));
  const auto wanting = std::count_if(parts.begin(), parts.end(), [&](const Part& part) {
    const auto found = count_.find(part);
    return found == count_.end() || found->second < times_seen_;
  });
  if (static_cast<double>(wanting) <= kFewNew * static_cast<double>(parts.size())) return false;
  for (const Part& part : parts) ++count_[part];
  return true;
}

}  // namespace edge_mcl
