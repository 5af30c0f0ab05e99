#include "edge_mcl/localization/lookup/image_lines.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_rays.h"

namespace edge_mcl {

namespace {

constexpr double kShortest = 1.5 * kDegree;
/// A segment is parallel to an axis when the plane through it holds the axis, up to this angle. The
/// direction of a segment of 20 pixels is good to about 2 degrees.
constexpr double kParallel = 2.5 * kDegree;

/// Whether most of a segment is under the mask.
bool isIgnored(const cv::Mat& ignore, const Eigen::Vector2d& start, const Eigen::Vector2d& end) {
  if (ignore.empty()) return false;
  constexpr int kSamples = 9;
  int under = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Vector2d p = start + (end - start) * i / (kSamples - 1);
    const int x = std::clamp(static_cast<int>(std::lround(p.x())), 0, ignore.cols - 1),
              y = std::clamp(static_cast<int>(std::lround(p.y())), 0, ignore.rows - 1);
    under += ignore.at<uint8_t>(y, x) != 0 ? 1 : 0;
  }
  return under > kSamples / 2;
}

/// Share of a segment that counts for an axis, from 1 (exactly parallel) to 0.
double agreement(double sine) {
  const double ratio = sine / std::sin(kParallel);
  return ratio < 1 ? 1 - ratio * ratio : 0;
}

double supportOf(const Eigen::Matrix3d& R_building_camera, const std::vector<ImageLine>& lines) {
  double support = 0;
  for (const ImageLine& line : lines)
    support += line.length * agreement((R_building_camera * line.normal).cwiseAbs().minCoeff());
  return support;
}

/// Fits the orientation to the segments that agree, and to "up". Gauss-Newton on small rotations of
/// the building's frame.
Eigen::Matrix3d fitted(Eigen::Matrix3d R, const std::vector<ImageLine>& lines, const KnownUp& up) {
  constexpr int kSteps = 4;
  constexpr double kSigma = kDegree;  // of the direction of a segment of one radian's weight
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix3d h = Eigen::Matrix3d::Identity();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const ImageLine& line : lines) {
      const Eigen::Vector3d n = R * line.normal;
      int axis = 0;
      const double sine = n.cwiseAbs().minCoeff(&axis);
      const double weight = line.length * agreement(sine) / (kSigma * kSigma);
      if (weight <= 0) continue;
      // d(n[axis]) / d(rotation vector): row `axis` of -[n]x.
      const Eigen::Vector3d j = n.cross(Eigen::Vector3d::Unit(axis));
      h += weight * j * j.transpose();
      g -= weight * n[axis] * j;
    }
    const Eigen::Vector3d tilt = (R * up.up_camera).cross(Eigen::Vector3d::UnitZ());
    const double weight = 1 / (up.sigma * up.sigma);
    h += weight * Eigen::Vector3d(1, 1, 0).asDiagonal().toDenseMatrix();
    g += weight * Eigen::Vector3d(tilt.x(), tilt.y(), 0);
    R = expSo3(h.ldlt().solve(g)) * R;
  }
  return R;
}

/// The frame whose vertical is the axis closest to "up". @param a, b perpendicular unit vectors in
/// the optical frame. @return R_building_camera
Eigen::Matrix3d uprightFrame(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                             const Eigen::Vector3d& up) {
  std::array<Eigen::Vector3d, 3> axes{a, b, a.cross(b)};
  const auto best = std::max_element(axes.begin(), axes.end(),
                                     [&](const Eigen::Vector3d& x, const Eigen::Vector3d& y) {
                                       return std::abs(x.dot(up)) < std::abs(y.dot(up));
                                     });
  std::iter_swap(best, axes.end() - 1);
  const Eigen::Vector3d vertical = axes[2].dot(up) < 0 ? Eigen::Vector3d(-axes[2]) : axes[2];
  Eigen::Matrix3d R;
  R.row(2) = vertical;
  R.row(0) = axes[0];
  R.row(1) = vertical.cross(axes[0]);
  return R;
}

/// Angle between two orientations that are equal up to quarter turns about the vertical.
double angleApart(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  double least = M_PI;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(quarter * M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    least = std::min(least, logSo3(a.transpose() * turn * b).norm());
  }
  return least;
}

}  // namespace

std::vector<ImageLine> findImageLines(const EdgeImage& image, const CameraModel& camera) {
  std::vector<cv::Vec4f> found;
  cv::createLineSegmentDetector(cv::LSD_REFINE_STD)->detect(image.grey, found);
  std::vector<ImageLine> lines;
  for (const cv::Vec4f& s : found) {
    const Eigen::Vector2d start(s[0], s[1]), end(s[2], s[3]);
    if (isIgnored(image.ignore, start, end)) continue;
    Eigen::Vector2d ray_start, ray_end;
    if (!unproject(camera, start, &ray_start) || !unproject(camera, end, &ray_end)) continue;
    ImageLine line;
    line.start = ray_start.homogeneous().normalized();
    line.end = ray_end.homogeneous().normalized();
    const Eigen::Vector3d normal = line.start.cross(line.end);
    line.length = std::atan2(normal.norm(), line.start.dot(line.end));
    if (!(line.length > kShortest)) continue;
    line.normal = normal.normalized();
    lines.push_back(line);
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const ImageLine& a, const ImageLine& b) { return a.length > b.length; });
  return lines;
}

std::vector<AxesRotation> rotationsOfAxes(const std::vector<ImageLine>& lines, const KnownUp& up,
                                          size_t most) {
  constexpr size_t kTried = 30;     // the longest segments make the hypotheses
  constexpr size_t kFitted = 40;    // hypotheses
  constexpr double kCertain = 0.1;  // rad; above it segments tell "up" better
  constexpr double kApart = 3 * kDegree;
  const size_t tried = std::min(kTried, lines.size());
  std::vector<Eigen::Vector3d> first;
  if (up.sigma < kCertain) {
    first.push_back(up.up_camera.normalized());
  } else {
    for (size_t i = 0; i < tried; ++i)
      for (size_t k = i + 1; k < tried; ++k) {
        const Eigen::Vector3d cross = lines[i].normal.cross(lines[k].normal);
        if (cross.norm() > std::sin(kParallel)) first.push_back(cross.normalized());
      }
  }
  std::vector<AxesRotation> found;
  for (const Eigen::Vector3d& a : first)
    for (size_t k = 0; k < tried; ++k) {
      const Eigen::Vector3d b = a.cross(lines[k].normal);
      if (b.norm() < 0.2) continue;  // the segment is nearly parallel to the first direction
      AxesRotation rotation;
      rotation.R_building_camera = uprightFrame(a, b.normalized(), up.up_camera);
      const double tilt = std::acos(
          std::clamp(rotation.R_building_camera.row(2).dot(up.up_camera.normalized()), -1.0, 1.0));
      if (tilt > std::max(3 * up.sigma, 3 * kDegree)) continue;
      rotation.support = supportOf(rotation.R_building_camera, lines);
      found.push_back(rotation);
    }
  const auto better = [](const AxesRotation& a, const AxesRotation& b) {
    return a.support > b.support;
  };
  std::stable_sort(found.begin(), found.end(), better);
  const auto distinct = [&](size_t limit, double apart) {
    std::vector<AxesRotation> kept;
    for (const AxesRotation& r : found) {
      if (kept.size() >= limit) break;
      if (std::none_of(kept.begin(), kept.end(), [&](const AxesRotation& k) {
            return angleApart(k.R_building_camera, r.R_building_camera) < apart;
          }))
        kept.push_back(r);
    }
    found = std::move(kept);
  };
  distinct(kFitted, kDegree);
  for (AxesRotation& r : found) {
    r.R_building_camera = fitted(r.R_building_camera, lines, up);
    r.support = supportOf(r.R_building_camera, lines);
  }
  std::stable_sort(found.begin(), found.end(), better);
  distinct(most, kApart);
  return found;
}

}  // namespace edge_mcl
