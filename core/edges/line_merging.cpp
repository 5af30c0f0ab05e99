#include "edge_mcl/core/edges/line_merging.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace edge_mcl {

namespace {

constexpr double kDirectionCell = 0.02;  // about one degree

/// A straight line without ends: direction with a fixed sign, point nearest to the centre.
struct InfiniteLine {
  Eigen::Vector3d direction, foot;
};

InfiniteLine lineOf(const EdgeLine& piece, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d start = piece.start.cast<double>() - centre;
  const Eigen::Vector3d end = piece.end.cast<double>() - centre;
  InfiniteLine line;
  line.direction = (end - start).normalized();
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(line.direction[axis]) > 0.1) {
      if (line.direction[axis] < 0) line.direction *= -1;
      break;
    }
  line.foot = start - line.direction * line.direction.dot(start);
  return line;
}

double distanceTo(const InfiniteLine& line, const Eigen::Vector3d& point) {
  const Eigen::Vector3d d = point - line.foot;
  return (d - line.direction * line.direction.dot(d)).norm();
}

using Key = std::array<int64_t, 6>;
struct KeyHash {
  size_t operator()(const Key& key) const {
    size_t hash = 1469598103934665603ull;
    for (int64_t k : key) hash = (hash ^ static_cast<size_t>(k)) * 1099511628211ull;
    return hash;
  }
};

class DisjointSets {
 public:
  explicit DisjointSets(size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
  }
  size_t find(size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(size_t a, size_t b) { parent_[find(b)] = find(a); }

 private:
  std::vector<size_t> parent_;
};

struct Interval {
  double from, to;
  size_t piece;
};

/// Appends the union of the intervals on `line`, a new piece for every gap.
void appendUnion(std::vector<Interval>* intervals, const InfiniteLine& line,
                 const Eigen::Vector3d& centre, const std::vector<EdgeLine>& pieces,
                 double tolerance, std::vector<EdgeLine>* merged) {
  std::sort(intervals->begin(), intervals->end(), [](const Interval& a, const Interval& b) {
    return a.from != b.from ? a.from < b.from : a.piece < b.piece;
  });
  size_t i = 0;
  while (i < intervals->size()) {
    double to = (*intervals)[i].to;
    size_t longest = (*intervals)[i].piece, j = i + 1;
    for (; j < intervals->size() && (*intervals)[j].from <= to + tolerance; ++j) {
      to = std::max(to, (*intervals)[j].to);
      const size_t piece = (*intervals)[j].piece;
      if (pieces[piece].length() > pieces[longest].length()) longest = piece;
    }
    EdgeLine joined = pieces[longest];
    if (j > i + 1) {
      joined.start = (centre + line.foot + line.direction * (*intervals)[i].from).cast<float>();
      joined.end = (centre + line.foot + line.direction * to).cast<float>();
    }
    merged->push_back(joined);
    i = j;
  }
}

}  // namespace

size_t mergeCollinear(std::vector<EdgeLine>* lines, double tolerance) {
  const size_t count = lines->size();
  if (count < 2) return 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const EdgeLine& l : *lines) centre += (l.start + l.end).cast<double>() / (2.0 * count);
  std::vector<InfiniteLine> infinite(count);
  for (size_t i = 0; i < count; ++i) infinite[i] = lineOf((*lines)[i], centre);

  const auto onSameLine = [&](size_t i, size_t j) {
    return distanceTo(infinite[i], (*lines)[j].start.cast<double>() - centre) <= tolerance &&
           distanceTo(infinite[i], (*lines)[j].end.cast<double>() - centre) <= tolerance;
  };
  // Two grids shifted by half a cell: neighbours that a border of one grid separates share a
  // cell of the other.
  DisjointSets sets(count);
  const double foot_cell = std::max(20 * tolerance, 1e-6);
  for (const double shift : {0.0, 0.5}) {
    std::unordered_map<Key, size_t, KeyHash> first_in_cell;
    first_in_cell.reserve(count);
    for (size_t i = 0; i < count; ++i) {
      Key key{};
      for (int axis = 0; axis < 3; ++axis) {
        key[axis] = std::llround(infinite[i].direction[axis] / kDirectionCell + shift);
        key[3 + axis] = std::llround(infinite[i].foot[axis] / foot_cell + shift);
      }
      const auto [it, fresh] = first_in_cell.emplace(key, i);
      if (fresh) continue;
      // The longest piece of a cell has the best direction: it represents the cell.
      if (onSameLine(it->second, i) || onSameLine(i, it->second)) sets.join(it->second, i);
      if ((*lines)[i].length() > (*lines)[it->second].length()) it->second = i;
    }
  }
  std::unordered_map<size_t, std::vector<size_t>> members;
  for (size_t i = 0; i < count; ++i) members[sets.find(i)].push_back(i);

  std::vector<EdgeLine> merged;
  for (size_t i = 0; i < count; ++i) {
    if (sets.find(i) != i) continue;
    const std::vector<size_t>& set = members[i];
    size_t longest = set.front();
    for (size_t j : set)
      if ((*lines)[j].length() > (*lines)[longest].length()) longest = j;
    std::vector<Interval> intervals;
    for (size_t j : set) {
      if (!onSameLine(longest, j)) {
        merged.push_back((*lines)[j]);
        continue;
      }
      const double a = infinite[longest].direction.dot((*lines)[j].start.cast<double>() - centre);
      const double b = infinite[longest].direction.dot((*lines)[j].end.cast<double>() - centre);
      intervals.push_back({std::min(a, b), std::max(a, b), j});
    }
    appendUnion(&intervals, infinite[longest], centre, *lines, tolerance, &merged);
  }
  *lines = std::move(merged);
  return count - lines->size();
}

uint32_t groupCurves(std::vector<EdgeLine>* lines, double tolerance) {
  const double largest_turn_cos = std::cos(35 * M_PI / 180);
  const double cell = std::max(4 * tolerance, 1e-6);
  using PointKey = std::array<int64_t, 3>;
  struct End {
    PointKey key;
    size_t line;
    Eigen::Vector3f outwards;  // direction in which the line would go on
  };
  std::vector<End> ends;
  for (size_t i = 0; i < lines->size(); ++i) {
    const auto keyOf = [&](const Eigen::Vector3f& p) {
      return PointKey{std::llround(p.x() / cell), std::llround(p.y() / cell),
                      std::llround(p.z() / cell)};
    };
    const Eigen::Vector3f t = (*lines)[i].tangent();
    ends.push_back({keyOf((*lines)[i].start), i, -t});
    ends.push_back({keyOf((*lines)[i].end), i, t});
  }
  std::sort(ends.begin(), ends.end(), [](const End& a, const End& b) {
    return a.key != b.key ? a.key < b.key : a.line < b.line;
  });
  DisjointSets sets(lines->size());
  for (size_t i = 0; i < ends.size();) {
    size_t j = i;
    while (j < ends.size() && ends[j].key == ends[i].key) ++j;
    // A curve goes on at a point if exactly one other line continues it there.
    for (size_t a = i; a < j; ++a) {
      size_t partners = 0, partner = a;
      for (size_t b = i; b < j; ++b)
        if (b != a && -ends[a].outwards.dot(ends[b].outwards) >= largest_turn_cos) {
          ++partners;
          partner = b;
        }
      if (partners == 1) sets.join(ends[a].line, ends[partner].line);
    }
    i = j;
  }
  std::vector<uint32_t> number(lines->size(), 0xffffffffu);
  uint32_t count = 0;
  for (size_t i = 0; i < lines->size(); ++i) {
    uint32_t& group = number[sets.find(i)];
    if (group == 0xffffffffu) group = count++;
    (*lines)[i].group = group;
  }
  std::stable_sort(lines->begin(), lines->end(),
                   [](const EdgeLine& a, const EdgeLine& b) { return a.group < b.group; });
  return count;
}

}  // namespace edge_mcl
