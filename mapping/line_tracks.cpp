#include "edge_mcl/mapping/line_tracks.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "edge_mcl/core/base/angles.h"

namespace edge_mcl {

namespace {

using Eigen::Vector3d;

/// Segments that belong to one line.
struct Track {
  Vector3d centre, direction;
  double low = 0, high = 0;  ///< extent along the direction from the centre, m
  std::vector<size_t> segments;
};

/// Finds the tracks near a segment by the cells of space that they pass.
class TrackGrid {
 public:
  explicit TrackGrid(double reach) : reach_(reach) {}

  void insert(uint32_t track, const Vector3d& start, const Vector3d& end) {
    forCells(start, end, [&](int64_t key) {
      std::vector<uint32_t>& list = cells_[key];
      if (list.empty() || list.back() != track) list.push_back(track);
    });
  }
  std::vector<uint32_t> near(const Vector3d& start, const Vector3d& end) const {
    std::vector<uint32_t> list;
    forCells(start, end, [&](int64_t key) {
      const auto it = cells_.find(key);
      if (it != cells_.end()) list.insert(list.end(), it->second.begin(), it->second.end());
    });
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
  }

 private:
  static constexpr double kCell = 0.5;

  template <class Visit>
  void forCells(const Vector3d& start, const Vector3d& end, const Visit& visit) const {
    const double length = (end - start).norm();
    const int steps = 1 + static_cast<int>(length / (kCell / 2));
    std::set<int64_t> keys;
    for (int i = 0; i <= steps; ++i) {
      const Vector3d p = start + (end - start) * (static_cast<double>(i) / steps);
      for (int corner = 0; corner < 8; ++corner) {
        const Vector3d q =
            p + reach_ * Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        int64_t key = 0;
        for (int k = 0; k < 3; ++k)
          key = key * 2097152 + (static_cast<int64_t>(std::floor(q[k] / kCell)) + 1048576);
        keys.insert(key);
      }
    }
    for (const int64_t key : keys) visit(key);
  }

  double reach_;
  std::unordered_map<int64_t, std::vector<uint32_t>> cells_;
};

/// Distance of a segment from a track when they may be one line, else nothing.
std::optional<double> distanceFrom(const Track& track, const DepthSegment& segment,
                                   const TrackOptions& options, double min_cos) {
  const Vector3d direction = (segment.end - segment.start).normalized();
  if (std::abs(direction.dot(track.direction)) < min_cos) return std::nullopt;
  double low = INFINITY, high = -INFINITY, distance = 0;
  for (const Vector3d& end : {segment.start, segment.end}) {
    const Vector3d d = end - track.centre;
    const double along = d.dot(track.direction);
    distance = std::max(distance, (d - along * track.direction).norm());
    low = std::min(low, along);
    high = std::max(high, along);
  }
  const double gap = std::max(low - track.high, track.low - high);
  if (distance > options.max_distance || gap > options.max_gap) return std::nullopt;
  return distance;
}

/// Joins segments, the longest first, since it has the most certain direction.
std::vector<Track> joinSegments(const std::vector<DepthSegment>& segments,
                                const TrackOptions& options) {
  std::vector<size_t> order(segments.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return segments[a].length() > segments[b].length(); });
  const double min_cos = std::cos(options.max_angle_deg * kDegree);
  std::vector<Track> tracks;
  TrackGrid grid(std::max(options.max_distance, options.max_gap));
  for (const size_t i : order) {
    const DepthSegment& s = segments[i];
    if (s.length() < options.min_length) continue;
    std::optional<uint32_t> nearest;
    double least = INFINITY;
    for (const uint32_t t : grid.near(s.start, s.end)) {
      const auto distance = distanceFrom(tracks[t], s, options, min_cos);
      if (distance && *distance < least) {
        least = *distance;
        nearest = t;
      }
    }
    if (!nearest) {
      nearest = static_cast<uint32_t>(tracks.size());
      tracks.push_back({(s.start + s.end) / 2, (s.end - s.start).normalized(), 0, 0, {}});
    }
    Track& track = tracks[*nearest];
    track.segments.push_back(i);
    for (const Vector3d& end : {s.start, s.end}) {
      const double along = (end - track.centre).dot(track.direction);
      track.low = std::min(track.low, along);
      track.high = std::max(track.high, along);
    }
    grid.insert(*nearest, s.start, s.end);
  }
  return tracks;
}

/// Estimates the line of a track. The four unknowns move its two ends across it.
class LineEstimate {
 public:
  LineEstimate(const Track& track, const std::vector<DepthSegment>& segments,
               const TrackOptions& options)
      : track_(track),
        segments_(segments),
        options_(options),
        start_(track.centre + track.low * track.direction),
        end_(track.centre + track.high * track.direction) {
    const Vector3d& d = track.direction;
    const Vector3d other = std::abs(d.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
    across_[0] = d.cross(other).normalized();
    across_[1] = d.cross(across_[0]);
  }

  /// @return false when the line does not settle near the track.
  bool solve() {
    constexpr int kSteps = 8;
    constexpr double kDelta = 1e-4, kSettled = 1e-5, kFarthest = 0.1;  // m
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::VectorXd residual = residuals(moved_);
      Eigen::MatrixXd jacobian(residual.size(), 4);
      for (int k = 0; k < 4; ++k) {
        Eigen::Vector4d other = moved_;
        other[k] += kDelta;
        jacobian.col(k) = (residuals(other) - residual) / kDelta;
      }
      // Huber's weights: a residual beyond 1.5 standard deviations counts less.
      const Eigen::VectorXd weight = (1.5 / residual.array().abs().max(1.5)).matrix();
      information_ = jacobian.transpose() * weight.asDiagonal() * jacobian;
      information_.diagonal().array() +=
          1;  // a standard deviation of 1 m, so that it has an inverse
      const Eigen::Vector4d change =
          information_.ldlt().solve(jacobian.transpose() * weight.asDiagonal() * residual);
      moved_ -= change;
      if (!moved_.allFinite() || moved_.cwiseAbs().maxCoeff() > kFarthest) return false;
      if (change.cwiseAbs().maxCoeff() < kSettled) break;
    }
    return true;
  }

  Vector3d start() const { return endOf(moved_, 0); }
  Vector3d end() const { return endOf(moved_, 1); }

  /// Standard deviation across the line in its middle, along the worse axis, with the noise that
  /// the residuals show.
  double sigma() const {
    const Eigen::VectorXd residual = residuals(moved_);
    const double noise =
        std::max(1.0, residual.squaredNorm() / std::max<long>(1, residual.size() - 4));
    const Eigen::Matrix4d covariance = noise * information_.inverse();
    Eigen::Matrix<double, 2, 4> middle;
    middle << 0.5, 0, 0.5, 0, 0, 0.5, 0, 0.5;
    const Eigen::Matrix2d c = middle * covariance * middle.transpose();
    return std::sqrt(std::max(c(0, 0), c(1, 1)));
  }

  /// Largest distance of the line from a segment in its image, px.
  double imageDistance(size_t segment) const {
    const DepthSegment& s = segments_[segment];
    return std::max(std::abs(imageResidual(s, s.start, start(), end())),
                    std::abs(imageResidual(s, s.end, start(), end())));
  }

 private:
  Vector3d endOf(const Eigen::Vector4d& moved, int end) const {
    return (end == 0 ? start_ : end_) + moved[2 * end] * across_[0] +
           moved[2 * end + 1] * across_[1];
  }
  /// The point of the line next to `point`, in camera axes.
  static Vector3d footInCamera(const DepthSegment& s, const Vector3d& point, const Vector3d& start,
                               const Vector3d& end) {
    const Vector3d d = (end - start).normalized();
    return s.T_map_camera.inverse() * Vector3d(start + d * d.dot(point - start));
  }
  /// Distance of the line's point next to `point` from the plane of the image segment, px.
  double imageResidual(const DepthSegment& s, const Vector3d& point, const Vector3d& start,
                       const Vector3d& end) const {
    const Vector3d foot = footInCamera(s, point, start, end);
    const Vector3d plane = s.ray_start.cross(s.ray_end).normalized();
    return options_.focal * plane.dot(foot) / std::max(foot.z(), 0.2);
  }
  Eigen::VectorXd residuals(const Eigen::Vector4d& moved) const {
    // The error of structured light: 1 cm, and 5 mm more at 1 m, growing with the square of the
    // depth. Depth beside an edge is less certain than elsewhere, hence twice that.
    const auto depthSigma = [](double z) { return 2 * (0.01 + 0.005 * z * z); };
    const Vector3d a = endOf(moved, 0), b = endOf(moved, 1);
    Eigen::VectorXd r(4 * static_cast<long>(track_.segments.size()));
    long at = 0;
    for (const size_t i : track_.segments) {
      const DepthSegment& s = segments_[i];
      for (const Vector3d& point : {s.start, s.end}) {
        const double z = (s.T_map_camera.inverse() * point).z();
        r[at++] = imageResidual(s, point, a, b) / options_.pixel_sigma;
        r[at++] = (footInCamera(s, point, a, b).z() - z) / depthSigma(z);
      }
    }
    return r;
  }

  const Track& track_;
  const std::vector<DepthSegment>& segments_;
  const TrackOptions& options_;
  Vector3d start_, end_;
  std::array<Vector3d, 2> across_;
  Eigen::Vector4d moved_ = Eigen::Vector4d::Zero();
  Eigen::Matrix4d information_ = Eigen::Matrix4d::Identity();
};

/// The pieces of a line that enough images have seen.
std::vector<MappedLine> piecesOf(const Track& track, const std::vector<DepthSegment>& segments,
                                 const TrackOptions& options) {
  constexpr double kBin = 0.02;      // m
  constexpr double kFarInImage = 3;  // pixel_sigma
  LineEstimate estimate(track, segments, options);
  if (!estimate.solve()) return {};
  const Vector3d start = estimate.start();
  const double length = (estimate.end() - start).norm();
  const Vector3d direction = (estimate.end() - start) / length;
  const auto bins = static_cast<size_t>(length / kBin) + 1;
  std::vector<std::set<uint32_t>> seen(bins);
  std::set<uint32_t> all;
  for (const size_t i : track.segments) {
    if (estimate.imageDistance(i) > kFarInImage * options.pixel_sigma) continue;
    const double a = (segments[i].start - start).dot(direction);
    const double b = (segments[i].end - start).dot(direction);
    const auto bin = [&](double along) {
      return static_cast<size_t>(std::clamp(along / kBin, 0.0, static_cast<double>(bins - 1)));
    };
    for (size_t k = bin(std::min(a, b)); k <= bin(std::max(a, b)); ++k)
      seen[k].insert(segments[i].image);
    all.insert(segments[i].image);
  }
  std::vector<MappedLine> pieces;
  for (size_t k = 0; k < bins;) {
    size_t next = k;
    while (next < bins && seen[next].size() >= options.min_views) ++next;
    const double from = static_cast<double>(k) * kBin;
    const double to = std::min(length, static_cast<double>(next) * kBin);
    if (next > k && to - from >= options.min_length)
      pieces.push_back(
          {start + from * direction, start + to * direction, estimate.sigma(), all.size()});
    k = next + 1;
  }
  return pieces;
}

/// Drops lines that lie along another one over most of their length. Those that more images have
/// seen stay.
std::vector<MappedLine> withoutCopies(std::vector<MappedLine> lines, double distance) {
  constexpr double kMostly = 0.7;     // of the length
  constexpr double kParallel = 0.99;  // cosine of 8 degrees
  std::stable_sort(lines.begin(), lines.end(), [](const MappedLine& a, const MappedLine& b) {
    return a.views != b.views ? a.views > b.views
                              : (a.end - a.start).norm() > (b.end - b.start).norm();
  });
  std::vector<MappedLine> kept;
  TrackGrid grid(distance);
  for (const MappedLine& line : lines) {
    const double length = (line.end - line.start).norm();
    const Vector3d direction = (line.end - line.start) / length;
    bool is_copy = false;
    for (const uint32_t i : grid.near(line.start, line.end)) {
      const Vector3d other = (kept[i].end - kept[i].start).normalized();
      if (std::abs(other.dot(direction)) < kParallel) continue;
      const Vector3d d = (line.start + line.end) / 2 - kept[i].start;
      const double along = d.dot(other), other_length = (kept[i].end - kept[i].start).norm();
      if ((d - along * other).norm() > distance) continue;
      const double common =
          std::min(along + length / 2, other_length) - std::max(along - length / 2, 0.0);
      is_copy = is_copy || common > kMostly * length;
    }
    if (is_copy) continue;
    grid.insert(static_cast<uint32_t>(kept.size()), line.start, line.end);
    kept.push_back(line);
  }
  return kept;
}

}  // namespace

std::vector<MappedLine> trackLines(const std::vector<DepthSegment>& segments,
                                   const TrackOptions& options) {
  std::vector<Track> tracks = joinSegments(segments, options);
  std::vector<std::vector<MappedLine>> pieces(tracks.size());
  tbb::parallel_for(size_t{0}, tracks.size(), [&](size_t t) {
    if (tracks[t].segments.size() >= options.min_views)
      pieces[t] = piecesOf(tracks[t], segments, options);
  });
  std::vector<MappedLine> lines;
  for (const auto& list : pieces) lines.insert(lines.end(), list.begin(), list.end());
  return withoutCopies(std::move(lines), options.same_distance);
}

}  // namespace edge_mcl
