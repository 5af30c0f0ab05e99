#include "edge_mcl/core/edges/line_cuts.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>
#include <utility>

namespace edge_mcl {

namespace {

using Eigen::Vector3d;

constexpr double kCell = 1;         // m, side of the cells in which pieces are looked up
constexpr double kOnLine = 3e-3;    // m; the table of an audit is rounded to 0.1 mm
constexpr double kShortest = 0.01;  // m; shorter remains of a line are dropped

uint64_t cellOf(const Vector3d& p) {
  // 21 bits per axis, as many as the map has metres in 2000 km.
  const auto part = [](double v) {
    return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v / kCell)) + (1 << 20)) &
           0x1fffffu;
  };
  return part(p.x()) << 42 | part(p.y()) << 21 | part(p.z());
}

/// Pieces by the cell of their middle.
class Pieces {
 public:
  explicit Pieces(const std::vector<std::array<Vector3d, 2>>& pieces) {
    for (size_t i = 0; i < pieces.size(); ++i)
      by_cell_[cellOf((pieces[i][0] + pieces[i][1]) / 2)].push_back(i);
  }

  /// Numbers of the pieces whose middle may lie on a line.
  std::set<size_t> near(const Vector3d& start, const Vector3d& end) const {
    std::set<size_t> found;
    const auto steps = static_cast<int>(std::ceil((end - start).norm() / (kCell / 2)));
    for (int i = 0; i <= steps; ++i) {
      const Vector3d at = start + (steps > 0 ? i / static_cast<double>(steps) : 0) * (end - start);
      for (int corner = 0; corner < 27; ++corner) {
        const Eigen::Vector3i shift(corner % 3 - 1, corner / 3 % 3 - 1, corner / 9 - 1);
        const auto cell = by_cell_.find(cellOf(at + kCell * shift.cast<double>()));
        if (cell != by_cell_.end()) found.insert(cell->second.begin(), cell->second.end());
      }
    }
    return found;
  }

 private:
  std::unordered_map<uint64_t, std::vector<size_t>> by_cell_;
};

}  // namespace

size_t cutOut(const std::vector<std::array<Vector3d, 2>>& pieces, std::vector<EdgeLine>* lines) {
  if (pieces.empty()) return 0;
  std::vector<bool> found(pieces.size(), false);
  const Pieces by_place(pieces);
  std::vector<EdgeLine> kept;
  for (const EdgeLine& line : *lines) {
    const Vector3d start = line.start.cast<double>(), way = line.end.cast<double>() - start;
    const double length = way.norm();
    std::vector<std::pair<double, double>> cuts;  // along the line, m
    for (const size_t i : by_place.near(start, start + way)) {
      std::array<double, 2> along{};
      double off = 0;
      for (size_t k = 0; k < 2; ++k) {
        const Vector3d to = pieces[i][k] - start;
        along[k] = to.dot(way) / std::max(length, 1e-9);
        off = std::max(off, (to - along[k] / std::max(length, 1e-9) * way).norm());
      }
      if (off >= kOnLine) continue;
      cuts.emplace_back(std::minmax(along[0], along[1]));
      found[i] = true;
    }
    if (cuts.empty()) {
      kept.push_back(line);
      continue;
    }
    std::sort(cuts.begin(), cuts.end());
    cuts.emplace_back(length, length);
    double begin = 0;
    for (const auto& [from, to] : cuts) {
      if (from - begin > kShortest) {
        EdgeLine piece = line;
        piece.start = (start + begin / length * way).cast<float>();
        piece.end = (start + std::min(from, length) / length * way).cast<float>();
        kept.push_back(piece);
      }
      begin = std::max(begin, to);
    }
  }
  *lines = std::move(kept);
  return static_cast<size_t>(std::count(found.begin(), found.end(), true));
}

}  // namespace edge_mcl
