#include "edge_mcl/audit/line_sights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/mesh/closest_point.h"

namespace edge_mcl {

namespace {

/// An image edge this near to a sample is the sample's, pixels of a 640 wide image: 2 cm at 2 m.
constexpr double kReach = 5;
/// Two directions are alike within this angle.
const double kAlike = std::cos(20 * kDegree);
/// Places where edges are found by chance, in multiples of the reach beside the line.
constexpr std::array<double, 4> kProbes{-4, -2.5, 2.5, 4};
/// Samples nearer than this many reaches to a line of another shape may show that line.
constexpr double kBeside = 2;
/// A face that is seen at a smaller angle does not separate its edges.
constexpr double kLeastFacing = 0.3;
/// Depth is compared this far inside the faces of a line, m: the depth of structured light is
/// smeared over some centimetres at an edge.
constexpr double kInside = 0.06;

/// Four standard deviations of the depth, m: 5 cm, and the noise of a Kinect (K. Khoshelham, S.
/// Elberink, 2012: 1.4 mm at 1 m, growing with the square).
double depthTolerance(double depth) { return std::max(0.05, 4 * 0.0014 * depth * depth); }

float depthAt(const cv::Mat& depth, const Eigen::Vector2d& pixel) {
  const auto x = static_cast<int>(std::lround(pixel.x()));
  const auto y = static_cast<int>(std::lround(pixel.y()));
  if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) return 0;
  return depth.at<float>(y, x);
}

}  // namespace

/// A sample of the model in the image.
struct LineSights::Sample {
  uint32_t segment = 0, line = 0;
  int shape = -1;
  Eigen::Vector3d point;  // map
  Eigen::Vector2d pixel, normal;
  double z = 0;
};

/// Finds samples by their pixel.
class LineSights::SampleGrid {
 public:
  SampleGrid(const std::vector<Sample>& samples, int width, int height)
      : samples_(samples), columns_(width / kCell + 1), cells_(columns_ * (height / kCell + 1)) {
    for (uint32_t i = 0; i < samples.size(); ++i)
      cells_[cell(samples[i].pixel.x(), samples[i].pixel.y())].push_back(i);
  }

  /// Whether a line with about this normal passes the pixel within the distance.
  /// @param counts tells which samples count.
  template <class Counts>
  bool hasNear(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double distance,
               const Counts& counts) const {
    const int reach = static_cast<int>(distance) / kCell + 1;
    const int x = static_cast<int>(pixel.x()) / kCell, y = static_cast<int>(pixel.y()) / kCell;
    const int rows = static_cast<int>(cells_.size()) / columns_;
    for (int v = std::max(0, y - reach); v <= std::min(rows - 1, y + reach); ++v)
      for (int u = std::max(0, x - reach); u <= std::min(columns_ - 1, x + reach); ++u)
        for (const uint32_t i : cells_[v * columns_ + u]) {
          const Sample& other = samples_[i];
          if (std::abs(other.normal.dot(normal)) >= kAlike &&
              (other.pixel - pixel).squaredNorm() < distance * distance && counts(other))
            return true;
        }
    return false;
  }

 private:
  static constexpr int kCell = 8;  // pixels
  size_t cell(double x, double y) const {
    const int row = static_cast<int>(y) / kCell, column = static_cast<int>(x) / kCell;
    return static_cast<size_t>(row) * columns_ + column;
  }
  const std::vector<Sample>& samples_;
  int columns_;
  std::vector<std::vector<uint32_t>> cells_;
};

LineSights::LineSights(const LocalizationMap& map) : map_(map), shapes_(findShapes(map.mesh())) {
  constexpr double kStep = 2e-3, kFar = 5e-3;  // m, from a line into its face, and to the face
  const EdgeModel& edges = map.edges();
  shape_of_segment_.assign(edges.segments.size(), -1);
  if (map.mesh().triangles.empty()) return;
  scene_ = std::make_unique<RayScene>(map.mesh());
  const ClosestFace faces(map.mesh());
  for (size_t i = 0; i < edges.segments.size(); ++i) {
    const EdgeSegment& segment = edges.segments[i];
    const Eigen::Vector3f& into = edges.lines[segment.line].into_a;
    if (into.isZero()) continue;
    const ClosestFace::Hit hit =
        faces.find((segment.centre + static_cast<float>(kStep) * into).cast<double>(), kFar);
    if (hit.found) shape_of_segment_[i] = static_cast<int>(shapes_.of_triangle[hit.face]);
  }
}

std::vector<LineSights::Sample> LineSights::samplesIn(const PreparedImage& image,
                                                      const Pose& T_map_camera) const {
  const CameraModel& camera = image.frame.camera;
  const VisibleSet set = map_.visibility().exact(T_map_camera.translation());
  const Pose camera_from_map = T_map_camera.inverse();
  std::vector<Sample> samples;
  for (const VisibleSet::Segment& segment : set.segments) {
    const EdgeSegment& edge = set.edgeSegment(segment);
    const EdgeLine& line = set.line(segment);
    if (VisibleSet::facingWeight(segment) < kLeastFacing) continue;
    const Eigen::Vector3d tangent = camera_from_map.linear() * line.tangent().cast<double>();
    for (uint32_t i = 0; i < edge.sample_count; ++i) {
      if (!(segment.samples >> i & 1u)) continue;
      Sample s;
      s.segment = segment.index;
      s.line = edge.line;
      s.shape = shape_of_segment_[segment.index];
      s.point = set.model->samplePosition(edge, i);
      const Eigen::Vector3d p = camera_from_map * s.point;
      Eigen::Matrix<double, 2, 3> projection;
      if (!camera.project(p, &s.pixel, &projection) || !camera.contains(s.pixel)) continue;
      const Eigen::Vector2d direction = projection * tangent;
      if (direction.squaredNorm() < 1e-12) continue;
      s.normal = Eigen::Vector2d(-direction.y(), direction.x()).normalized();
      s.z = p.z();
      samples.push_back(s);
    }
  }
  return samples;
}

bool LineSights::isHidden(const Sample& sample, const cv::Mat& depth) {
  if (depth.empty()) return false;
  const auto seen = static_cast<double>(depthAt(depth, sample.pixel));
  return seen > 0 && seen < sample.z - depthTolerance(sample.z) - kInside;
}

void LineSights::addDepth(const Sample& sample, const PreparedImage& image, const cv::Mat& depth,
                          const Pose& T_map_camera, LineSight* sight) const {
  if (!scene_ || sample.shape < 0) return;
  const EdgeLine& line = map_.edges().lines[sample.line];
  const Pose camera_from_map = T_map_camera.inverse();
  const Eigen::Vector3f eye = T_map_camera.translation().cast<float>();
  for (const Eigen::Vector3f& into : {line.into_a, line.into_b}) {
    if (into.isZero()) continue;
    const Eigen::Vector3d inside = sample.point + kInside * into.cast<double>();
    const Eigen::Vector3d p = camera_from_map * inside;
    Eigen::Vector2d pixel;
    if (!image.frame.camera.project(p, &pixel)) continue;
    const auto seen = static_cast<double>(depthAt(depth, pixel));
    if (!(seen > 0)) continue;
    const Eigen::Vector3f direction = inside.cast<float>() - eye;
    constexpr float kBeyond = 10;  // the surface may stand behind the place
    const std::optional<RayHit> hit = firstHit(scene_->get(), eye, direction, 0, kBeyond);
    // Where another shape is in front, the depth tells nothing about this one.
    if (!hit || static_cast<int>(shapes_.of_triangle[hit->triangle]) != sample.shape) continue;
    const double expected = p.z() * static_cast<double>(hit->along);
    const double tolerance = depthTolerance(expected);
    if (seen > expected + tolerance)
      sight->behind += 1;
    else if (seen > expected - tolerance)
      sight->on_surface += 1;
  }
}

std::vector<LineSight> LineSights::find(const PreparedImage& image, const cv::Mat& depth,
                                        const Pose& T_map_camera) const {
  const CameraModel& camera = image.frame.camera;
  const std::vector<Sample> samples = samplesIn(image, T_map_camera);
  const SampleGrid grid(samples, camera.width, camera.height);
  const double reach = kReach * image.pixel_scale;
  const auto tolerance =
      static_cast<float>(std::cos(map_.params().image.orientation_tolerance_deg * kDegree));
  const auto isIgnored = [&](const Eigen::Vector2d& at) {
    return !image.edges.ignore.empty() &&
           image.edges.ignore.at<uint8_t>(static_cast<int>(std::lround(at.y())),
                                          static_cast<int>(std::lround(at.x()))) != 0;
  };
  const auto hasEdge = [&](const Eigen::Vector2d& at, const Eigen::Vector2d& normal) {
    return image.pixels.nearestAlong(static_cast<float>(at.x()), static_cast<float>(at.y()),
                                     static_cast<float>(normal.x()), static_cast<float>(normal.y()),
                                     static_cast<float>(reach), tolerance) != nullptr;
  };
  const auto isUsable = [&](const Eigen::Vector2d& at, const Eigen::Vector2d& normal) {
    for (const double side : {-reach, 0.0, reach}) {
      const Eigen::Vector2d p = at + side * normal;
      if (!camera.contains(p) || isIgnored(p)) return false;
    }
    return true;
  };
  std::vector<LineSight> sights;
  for (const Sample& s : samples) {
    if (!isUsable(s.pixel, s.normal)) continue;
    if (sights.empty() || sights.back().segment != s.segment)
      sights.push_back(LineSight{s.segment, 0, 0, 0, 0, 0, 0});
    LineSight& sight = sights.back();
    if (!depth.empty()) addDepth(s, image, depth, T_map_camera, &sight);
    // Edges of one shape exist together, so they may stand for one another.
    const auto isAnother = [&](const Sample& other) {
      return other.line != s.line && (other.shape != s.shape || s.shape < 0);
    };
    if (isHidden(s, depth) || grid.hasNear(s.pixel, s.normal, kBeside * reach, isAnother)) continue;
    sight.samples += 1;
    sight.shown += hasEdge(s.pixel, s.normal) ? 1 : 0;
    for (const double probe : kProbes) {
      const Eigen::Vector2d at = s.pixel + probe * reach * s.normal;
      if (!isUsable(at, s.normal) ||
          grid.hasNear(at, s.normal, kBeside * reach, [](const Sample&) { return true; }))
        continue;
      sight.probes += 1;
      sight.by_chance += hasEdge(at, s.normal) ? 1 : 0;
    }
  }
  return sights;
}

}  // namespace edge_mcl
