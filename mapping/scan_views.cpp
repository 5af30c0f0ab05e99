#include "edge_mcl/mapping/scan_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/mesh/closest_point.h"

namespace edge_mcl {

namespace {

/// A wide camera, so that few views show everything: 90 degrees.
CameraModel wideCamera() {
  constexpr int kSize = 640;
  CameraModel camera;
  camera.width = camera.height = kSize;
  camera.fx = camera.fy = kSize / 2.0;
  camera.cx = camera.cy = (kSize - 1) / 2.0;
  camera.validate("camera of the scan's views");
  return camera;
}

/// Normals of the vertices, weighted by the areas of their faces.
std::vector<Eigen::Vector3f> vertexNormals(const MeshModel& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices[t[0]];
    const Eigen::Vector3f area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    for (const uint32_t v : t) normals[v] += area;
  }
  for (Eigen::Vector3f& n : normals) n.normalize();
  return normals;
}

/// Smooths normals along the surface but not across its creases: every normal becomes the mean of
/// its neighbours, which count less the more they differ (a bilateral filter of normals, Y. Zheng
/// et al., "Bilateral normal filtering for mesh denoising", TVCG 2011).
void smoothNormals(const MeshModel& mesh, std::vector<Eigen::Vector3f>* normals) {
  // The noise of depth cameras tilts faces of 4 cm by 10 degrees. Normals that differ by 30 degrees
  // have a weight of exp(-1), across a right angle one of exp(-7).
  constexpr int kRounds = 3;
  const float width = 1 - std::cos(30.f * static_cast<float>(M_PI) / 180);
  std::vector<Eigen::Vector3f> next(normals->size());
  for (int round = 0; round < kRounds; ++round) {
    next = *normals;
    for (const auto& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) {
        // Each edge within a surface is visited from both of its faces.
        const uint32_t a = t[k], b = t[(k + 1) % 3];
        const float weight = 0.5f * std::exp(-(1 - (*normals)[a].dot((*normals)[b])) / width);
        next[a] += weight * (*normals)[b];
        next[b] += weight * (*normals)[a];
      }
    for (Eigen::Vector3f& n : next) n.normalize();
    normals->swap(next);
  }
}

/// A camera that looks along a heading (about the map's z axis) with a pitch (down is positive).
Eigen::Matrix3d lookingAlong(double heading, double pitch) {
  const Eigen::Vector3d forward(std::cos(heading) * std::cos(pitch),
                                std::sin(heading) * std::cos(pitch), -std::sin(pitch));
  const Eigen::Vector3d right(std::sin(heading), -std::cos(heading), 0);
  Eigen::Matrix3d axes;
  axes << right, forward.cross(right), forward;
  return axes;
}

/// Image of the steps of depth. The inverse depth of a plane is linear in the image, so its second
/// difference is zero on planes, small at creases and large at steps.
cv::Mat stepsOf(const cv::Mat& depth) {
  constexpr float kStep = 0.012f;  // 1/m: 5 cm at 2 m, 11 cm at 3 m
  cv::Mat steps(depth.size(), CV_8U, cv::Scalar(0));
  const auto inverse = [&](int y, int x) {
    const float z = depth.at<float>(y, x);
    return z > 0 ? 1 / z : std::numeric_limits<float>::quiet_NaN();
  };
  for (int y = 1; y + 1 < depth.rows; ++y)
    for (int x = 1; x + 1 < depth.cols; ++x) {
      const float here = 2 * inverse(y, x);
      // A comparison with NaN is false, so the border of the scan is no step.
      if (std::abs(inverse(y, x - 1) + inverse(y, x + 1) - here) > kStep ||
          std::abs(inverse(y - 1, x) + inverse(y + 1, x) - here) > kStep)
        steps.at<uint8_t>(y, x) = 200;
    }
  cv::dilate(steps, steps, cv::Mat());
  return steps;
}

/// Directions of a place that cover the sphere evenly (Fibonacci's lattice).
constexpr int kRaysOfPlace = 128;

}  // namespace

ScanViews::ScanViews(const MeshModel& mesh)
    : mesh_(mesh),
      scene_(mesh),
      vertex_normals_(vertexNormals(mesh)),
      camera_(wideCamera()),
      rays_(std::make_unique<CameraRays>(camera_)) {
  smoothNormals(mesh_, &vertex_normals_);
}

ScanViews::Surface ScanViews::surfaceAt(const Eigen::Vector3f& from,
                                        const Eigen::Vector3f& direction) const {
  const std::optional<RayHit> hit = firstHit(scene_.get(), from, direction, 0, INFINITY);
  if (!hit) return {};
  const auto& t = mesh_.triangles[hit->triangle];
  const Eigen::Vector3f a = mesh_.vertices[t[0]];
  const Eigen::Vector3f face = (mesh_.vertices[t[1]] - a).cross(mesh_.vertices[t[2]] - a);
  if (face.dot(direction) > 0) return {};
  const Eigen::Vector3f normal = (1 - hit->u - hit->v) * vertex_normals_[t[0]] +
                                 hit->u * vertex_normals_[t[1]] + hit->v * vertex_normals_[t[2]];
  return {hit->along, normal.normalized()};
}

std::vector<SurfacePiece> ScanViews::frontsFrom(const Eigen::Vector3d& place) const {
  std::vector<SurfacePiece> fronts;
  const double golden = M_PI * (3 - std::sqrt(5.0));
  for (int i = 0; i < kRaysOfPlace; ++i) {
    const double z = 1 - (2 * i + 1.0) / kRaysOfPlace, radius = std::sqrt(1 - z * z);
    const Eigen::Vector3f d(static_cast<float>(radius * std::cos(golden * i)),
                            static_cast<float>(radius * std::sin(golden * i)),
                            static_cast<float>(z));
    const Surface s = surfaceAt(place.cast<float>(), d);
    if (s.distance > 0)
      fronts.push_back({place.cast<float>() + s.distance * d, s.normal, s.distance});
  }
  return fronts;
}

std::vector<ScanViews::View> ScanViews::views(const ScanPlaces& wanted) const {
  // A scan may show one side of a room only, and its outside shows backs. Places from which fewer
  // rays than this meet fronts see nothing that others do not see.
  constexpr double kInside = 0.15, kClearance = 0.25;
  constexpr int kHeadings = 8;
  constexpr std::array<double, 3> kPitches{-0.5, 0, 0.5};
  const ClosestFace closest(mesh_);
  SeenSurface seen(wanted.times_seen, wanted.far);
  std::vector<View> result;
  uint32_t number = 0;
  const auto visit = [&](const Eigen::Vector3d& place) {
    if (closest.find(place, kClearance).found) return;
    const std::vector<SurfacePiece> fronts = frontsFrom(place);
    if (static_cast<double>(fronts.size()) < kInside * kRaysOfPlace || !seen.add(fronts)) return;
    for (int h = 0; h < kHeadings; ++h)
      for (const double pitch : kPitches) {
        Pose pose = Pose::Identity();
        pose.linear() = lookingAlong(2 * M_PI * h / kHeadings, pitch);
        pose.translation() = place;
        result.push_back({pose, number});
      }
    ++number;
  };
  forSpreadPlaces(mesh_.lowest.cast<double>(), mesh_.highest.cast<double>(), wanted.spacing, visit);
  return result;
}

std::vector<MappingImage> ScanViews::render(const View& view) const {
  // Noise of 3 mm moves a surface by 17 mm along a ray that meets it at 10 degrees. Surfaces that
  // are seen so flat would show steps of depth that are none.
  constexpr float kGrazing = 0.17f;
  const int width = camera_.width, height = camera_.height;
  cv::Mat depth(height, width, CV_32F, cv::Scalar(0));
  cv::Mat normals(height, width, CV_32FC3, cv::Scalar(0, 0, 0));
  const Eigen::Vector3f from = view.T_map_camera.translation().cast<float>();
  const Eigen::Matrix3f axes = view.T_map_camera.linear().cast<float>();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2f& r = rays_->at(x, y);
      const Eigen::Vector3f direction = axes * Eigen::Vector3f(r.x(), r.y(), 1);
      const Surface s = surfaceAt(from, direction);
      if (s.distance <= 0 || -s.normal.dot(direction) < kGrazing * direction.norm()) continue;
      depth.at<float>(y, x) = s.distance;  // the direction has length 1 along the optical axis
      normals.at<cv::Vec3f>(y, x) = {s.normal.x(), s.normal.y(), s.normal.z()};
    }
  // The noise of a scan is a matter of neighbouring faces. The median keeps the edges.
  constexpr int kMedian = 5;
  std::vector<MappingImage> images;
  const auto append = [&](const cv::Mat& grey) {
    cv::Mat smooth;
    cv::medianBlur(grey, smooth, kMedian);
    images.push_back({smooth, depth, view.T_map_camera, view.place});
  };
  // The detector needs steps of some 5 grey levels, which is a crease of 7 degrees or more.
  constexpr double kGreyPerNormal = 70;
  std::vector<cv::Mat> channels;
  cv::split(normals, channels);
  for (const cv::Mat& channel : channels) {
    cv::Mat grey;
    channel.convertTo(grey, CV_8U, kGreyPerNormal, 128);
    append(grey);
  }
  const cv::Mat steps = stepsOf(depth);
  append(steps);
  return images;
}

}  // namespace edge_mcl
