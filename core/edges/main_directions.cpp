#include "edge_mcl/core/edges/main_directions.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

std::vector<Eigen::Vector3d> mainDirections(const EdgeModel& model) {
  constexpr size_t kTried = 300;  // only the longest lines are tried
  const double kAlong = std::cos(3 * M_PI / 180), kApart = std::cos(30 * M_PI / 180);
  constexpr double kHardlyAny = 0.05;
  struct Line {
    Eigen::Vector3d direction;
    double length;
  };
  std::vector<Line> lines;
  for (const EdgeLine& line : model.lines)
    if (line.kind != EdgeKind::kContour)
      lines.push_back({line.tangent().cast<double>(), static_cast<double>(line.length())});
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return a.length > b.length; });

  std::vector<Eigen::Vector3d> found;
  double most = 0;
  while (found.size() < 3) {
    Line best{Eigen::Vector3d::Zero(), 0};
    for (size_t i = 0; i < std::min(kTried, lines.size()); ++i) {
      const Eigen::Vector3d& d = lines[i].direction;
      if (std::any_of(found.begin(), found.end(),
                      [&](const Eigen::Vector3d& f) { return std::abs(f.dot(d)) > kApart; }))
        continue;
      double length = 0;
      for (const Line& other : lines)
        if (std::abs(other.direction.dot(d)) > kAlong) length += other.length;
      if (length > best.length) best = {d, length};
    }
    if (best.length <= kHardlyAny * most) break;
    most = std::max(most, best.length);
    found.push_back(best.direction);
  }
  return found;
}

}  // namespace edge_mcl
