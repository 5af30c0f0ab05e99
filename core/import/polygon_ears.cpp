#include "edge_mcl/core/import/polygon_ears.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace edge_mcl {

namespace {

using Eigen::Vector3d;

constexpr double kStraight = 1e-3;  // smallest sine of the turn at a convex corner
/// Limit of three ratios: twice the area of a triangle to the square of its longest side, the
/// square of a corner's distance from the plane to twice the area of the polygon, and the slack of
/// covers() to twice the area of the triangle.
constexpr double kFlat = 1e-5;

/// Normal of a polygon. Its length is twice the area.
Vector3d newellNormal(const std::vector<Vector3d>& corners) {
  Vector3d normal = Vector3d::Zero();
  for (size_t i = 0; i < corners.size(); ++i)
    normal += (corners[i] - corners[0]).cross(corners[(i + 1) % corners.size()] - corners[0]);
  return normal;
}

/// Twice the area of a triangle, seen along a unit normal. It is positive when the triangle turns
/// counter-clockwise about the normal.
double areaOf(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& normal) {
  return (b - a).cross(c - a).dot(normal);
}

/// Twice the area of a triangle divided by the square of its longest side. It is 0.87 when all
/// sides are equal.
double fatnessOf(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& normal) {
  const double longest =
      std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return longest > 0 ? areaOf(a, b, c, normal) / longest : 0;
}

/// Whether p lies inside the triangle (a, b, c) or on its border.
bool covers(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& p,
            const Vector3d& normal) {
  const double slack = -kFlat * areaOf(a, b, c, normal);
  return areaOf(a, b, p, normal) >= slack && areaOf(b, c, p, normal) >= slack &&
         areaOf(c, a, p, normal) >= slack;
}

}  // namespace

bool isStrictlyConvex(const std::vector<Vector3d>& corners) {
  const size_t n = corners.size();
  const Vector3d normal = newellNormal(corners).normalized();
  for (size_t i = 0; i < n; ++i) {
    const Vector3d in = corners[(i + 1) % n] - corners[i];
    const Vector3d out = corners[(i + 2) % n] - corners[(i + 1) % n];
    if (!(in.cross(out).dot(normal) > kStraight * in.norm() * out.norm())) return false;
  }
  return true;
}

std::vector<std::array<unsigned, 3>> cutEars(const std::vector<Vector3d>& corners) {
  constexpr size_t kMost = 300;
  const size_t n = corners.size();
  if (n < 3 || n > kMost) return {};
  Vector3d normal = newellNormal(corners);
  const double whole = normal.norm();
  if (!(whole > 0)) return {};
  normal /= whole;

  // A corner that occurs twice in a row counts once.
  std::vector<unsigned> left;
  for (unsigned i = 0; i < n; ++i) {
    if (corners[i] != corners[(i + 1) % n]) left.push_back(i);
    const double off = (corners[i] - corners[0]).dot(normal);
    if (off * off > kFlat * whole) return {};
  }
  std::vector<std::array<unsigned, 3>> triangles;
  while (left.size() >= 3) {
    const size_t count = left.size();
    double fattest = kFlat;
    size_t best = count;
    for (size_t i = 0; i < count; ++i) {
      const Vector3d &a = corners[left[(i + count - 1) % count]], &b = corners[left[i]],
                     &c = corners[left[(i + 1) % count]];
      const double fatness = fatnessOf(a, b, c, normal);
      if (fatness <= fattest) continue;
      // Corners at the same place as a, b or c do not count: they belong to a bridge to a hole.
      if (std::any_of(left.begin(), left.end(), [&](unsigned k) {
            const Vector3d& p = corners[k];
            return p != a && p != b && p != c && covers(a, b, c, p, normal);
          }))
        continue;
      fattest = fatness;
      best = i;
    }
    if (best == count) return {};
    triangles.push_back({left[(best + count - 1) % count], left[best], left[(best + 1) % count]});
    if (count == 3) break;
    left.erase(left.begin() + static_cast<long>(best));
  }
  return triangles;
}

}  // namespace edge_mcl
