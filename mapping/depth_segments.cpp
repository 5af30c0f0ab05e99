#include "edge_mcl/mapping/depth_segments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace edge_mcl {

namespace {

/// Depth at a point of a segment.
struct DepthSample {
  double along = 0;          ///< pixels from the start of the segment
  double inverse_depth = 0;  ///< 1/m
};

/// Reads the depth beside a segment.
class SideReader {
 public:
  SideReader(const cv::Mat& depth, double min_extrapolation)
      : depth_(depth), min_extrapolation_(min_extrapolation) {}

  /// Inverse depth of a surface at a point of its border, from the pixels beside it. Nearer pixels
  /// than two are those of the edge itself, where depth cameras mix both sides. The inverse depth
  /// of a plane is linear in the image, so it is extrapolated to the border. A mean would place a
  /// crease too near, by decimetres where a floor is seen at a small angle. @return 0 without
  /// depth.
  double at(const Eigen::Vector2d& point, const Eigen::Vector2d& normal) const {
    constexpr int kFirst = 2, kLast = 6, kFewest = 3;
    constexpr double kMostChange = 0.1;  // a larger share means that the surface is no plane there
    constexpr int kNear = 4;             // pixels up to here give the mean
    int count = 0, near_count = 0;
    double near_sum = 0, sum = 0, sum_x = 0, sum_xx = 0, sum_xy = 0;
    for (int offset = kFirst; offset <= kLast; ++offset) {
      const Eigen::Vector2d p = point + offset * normal;
      const auto x = static_cast<int>(std::lround(p.x())), y = static_cast<int>(std::lround(p.y()));
      if (x < 0 || y < 0 || x >= depth_.cols || y >= depth_.rows) continue;
      const float z = depth_.at<float>(y, x);
      if (!(z > 0) || !std::isfinite(z)) continue;
      const double inverse = 1 / static_cast<double>(z);
      ++count;
      sum += inverse;
      if (offset <= kNear) {
        ++near_count;
        near_sum += inverse;
      }
      sum_x += offset;
      sum_xx += offset * offset;
      sum_xy += offset * inverse;
    }
    if (near_count == 0) return 0;
    const double near_mean = near_sum / near_count;
    if (count < kFewest) return near_mean;
    const double mean = sum / count, mean_x = sum_x / count;
    const double slope = (sum_xy - count * mean * mean_x) / (sum_xx - count * mean_x * mean_x);
    const double at_border = mean - slope * mean_x;
    const double change = std::abs(at_border - near_mean) / near_mean;
    return change >= min_extrapolation_ && change < kMostChange ? at_border : near_mean;
  }

 private:
  const cv::Mat& depth_;
  double min_extrapolation_;
};

/// Depths along a segment. At a step the nearer side counts, otherwise the mean of both.
std::vector<DepthSample> depthsAlong(const cv::Mat& depth, const Eigen::Vector2d& start,
                                     const Eigen::Vector2d& end, const SegmentOptions& options) {
  constexpr double kStep = 2;            // pixels between samples
  constexpr double kSameSurface = 0.03;  // relative difference of the depths of one surface
  const double length = (end - start).norm();
  const Eigen::Vector2d direction = (end - start) / length;
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  const SideReader reader(depth, options.min_extrapolation);
  std::vector<DepthSample> samples;
  for (double along = 0; along <= length; along += kStep) {
    const Eigen::Vector2d point = start + along * direction;
    const double left = reader.at(point, -normal), right = reader.at(point, normal);
    if (options.needs_both_sides ? left <= 0 || right <= 0 : left <= 0 && right <= 0) continue;
    double inverse = std::max(left, right);
    if (left > 0 && right > 0 && std::abs(left - right) < kSameSurface * inverse)
      inverse = (left + right) / 2;
    if (inverse * options.max_depth < 1) continue;
    samples.push_back({along, inverse});
  }
  return samples;
}

/// The inverse depth along a segment, which is linear in the image for a straight line in space.
struct InverseDepth {
  double at_zero = 0, slope = 0;
  double at(double along) const { return at_zero + slope * along; }
};

/// Fits a line to the samples that agree best. The candidates are the lines through all pairs of
/// some samples, so the result does not depend on chance.
std::optional<InverseDepth> fitInverseDepth(const std::vector<DepthSample>& samples,
                                            double tolerance, std::vector<bool>* inlier) {
  constexpr size_t kCandidates = 12;
  if (samples.size() < kCandidates) return std::nullopt;
  const auto sampleAt = [&](size_t i) -> const DepthSample& {
    return samples[i * (samples.size() - 1) / (kCandidates - 1)];
  };
  const auto agreeing = [&](const InverseDepth& line) {
    return std::count_if(samples.begin(), samples.end(), [&](const DepthSample& s) {
      return std::abs(line.at(s.along) - s.inverse_depth) < tolerance;
    });
  };
  InverseDepth best;
  long most = 0;
  for (size_t i = 0; i < kCandidates; ++i)
    for (size_t j = i + 2; j < kCandidates; ++j) {
      const DepthSample &a = sampleAt(i), &b = sampleAt(j);
      if (b.along <= a.along) continue;
      const double slope = (b.inverse_depth - a.inverse_depth) / (b.along - a.along);
      const InverseDepth line{a.inverse_depth - slope * a.along, slope};
      if (const long count = agreeing(line); count > most) {
        most = count;
        best = line;
      }
    }
  if (most == 0) return std::nullopt;
  // Least squares over the samples that agree.
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  inlier->assign(samples.size(), false);
  for (size_t i = 0; i < samples.size(); ++i) {
    const DepthSample& s = samples[i];
    if (std::abs(best.at(s.along) - s.inverse_depth) >= tolerance) continue;
    (*inlier)[i] = true;
    const Eigen::Vector2d row(1, s.along);
    normal += row * row.transpose();
    right += row * s.inverse_depth;
  }
  if (std::abs(normal.determinant()) < 1e-9) return std::nullopt;
  const Eigen::Vector2d solved = normal.inverse() * right;
  return InverseDepth{solved.x(), solved.y()};
}

/// Ray (X/Z, Y/Z, 1) of a point between pixels.
Eigen::Vector3d rayAt(const CameraRays& rays, const Eigen::Vector2d& pixel) {
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, rays.width() - 1);
  const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, rays.height() - 1);
  const CameraRays::Slope slope = rays.slopeAt(x, y);
  const Eigen::Vector2f ray = rays.at(x, y) + slope.by_x * static_cast<float>(pixel.x() - x) +
                              slope.by_y * static_cast<float>(pixel.y() - y);
  return {static_cast<double>(ray.x()), static_cast<double>(ray.y()), 1};
}

/// Lifts a segment of the image to the map.
std::optional<DepthSegment> lifted(const MappingImage& image, const CameraRays& rays,
                                   const Eigen::Vector2d& start, const Eigen::Vector2d& end,
                                   const SegmentOptions& options) {
  const std::vector<DepthSample> samples = depthsAlong(image.depth, start, end, options);
  std::vector<bool> inlier;
  const auto line = fitInverseDepth(samples, options.inverse_depth_tolerance, &inlier);
  if (!line) return std::nullopt;
  const double length = (end - start).norm();
  const auto inliers = static_cast<double>(std::count(inlier.begin(), inlier.end(), true));
  if (inliers < options.min_inliers * length / 2) return std::nullopt;
  const auto first = std::find(inlier.begin(), inlier.end(), true) - inlier.begin();
  const auto last = inlier.rend() - std::find(inlier.rbegin(), inlier.rend(), true) - 1;
  DepthSegment segment;
  segment.image = image.number;
  segment.T_map_camera = image.T_map_camera;
  const auto place = [&](double along, Eigen::Vector3d* ray, Eigen::Vector3d* point) {
    const double inverse = line->at(along);
    *ray = rayAt(rays, start + (end - start) * (along / length));
    if (inverse * options.max_depth < 0.5 || !ray->allFinite()) return false;
    *point = image.T_map_camera * Eigen::Vector3d(*ray / inverse);
    return true;
  };
  if (!place(samples[static_cast<size_t>(first)].along, &segment.ray_start, &segment.start) ||
      !place(samples[static_cast<size_t>(last)].along, &segment.ray_end, &segment.end) ||
      segment.length() < options.min_length)
    return std::nullopt;
  return segment;
}

}  // namespace

std::vector<DepthSegment> findDepthSegments(const MappingImage& image, const CameraRays& rays,
                                            const SegmentOptions& options) {
  std::vector<cv::Vec4f> found;
  cv::createLineSegmentDetector(cv::LSD_REFINE_STD)->detect(image.grey, found);
  std::vector<DepthSegment> segments;
  for (const cv::Vec4f& f : found) {
    const Eigen::Vector2d start(static_cast<double>(f[0]), static_cast<double>(f[1]));
    const Eigen::Vector2d end(static_cast<double>(f[2]), static_cast<double>(f[3]));
    if ((end - start).norm() < options.min_pixels) continue;
    if (const auto segment = lifted(image, rays, start, end, options)) segments.push_back(*segment);
  }
  return segments;
}

}  // namespace edge_mcl
