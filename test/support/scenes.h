/// Geometry and pictures for the tests, independent of the code under test.
#pragma once

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl::test {

/// Adds an axis-aligned box. Its faces point outward, or inward if wanted.
inline void addBox(MeshSoup* soup, const Eigen::Vector3f& low, const Eigen::Vector3f& high,
                   uint32_t material = 0, bool inward = false) {
  const auto base = static_cast<uint32_t>(soup->vertices.size());
  for (int i = 0; i < 8; ++i)
    soup->vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                                i & 4 ? high.z() : low.z());
  const uint32_t quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& q : quads) {
    std::array<uint32_t, 3> a{base + q[0], base + q[1], base + q[2]},
        b{base + q[0], base + q[2], base + q[3]};
    if (inward) {
      std::swap(a[1], a[2]);
      std::swap(b[1], b[2]);
    }
    soup->triangles.push_back(a);
    soup->triangles.push_back(b);
    soup->triangle_material.push_back(material);
    soup->triangle_material.push_back(material);
  }
}

/// Two furnished rooms of 4 x 5 x 2.6 m side by side. The wall between them has a doorway.
inline MeshModel furnishedRooms() {
  MeshSoup soup;
  addBox(&soup, {0, 0, 0}, {8, 5, 2.6f}, 0, true);
  addBox(&soup, {3.95f, 0, 0}, {4.05f, 2, 2.6f});
  addBox(&soup, {3.95f, 3, 0}, {4.05f, 5, 2.6f});
  addBox(&soup, {3.95f, 2, 2.1f}, {4.05f, 3, 2.6f});
  addBox(&soup, {0.3f, 0.2f, 0}, {1.9f, 1.0f, 0.75f});     // desk
  addBox(&soup, {0.5f, 0.3f, 0.75f}, {1.1f, 0.4f, 1.2f});  // screen
  addBox(&soup, {2.9f, 4.2f, 0}, {3.8f, 4.9f, 1.9f});      // cupboard
  addBox(&soup, {5.0f, 3.5f, 0}, {7.0f, 4.4f, 0.45f});     // bed
  addBox(&soup, {5.6f, 0.3f, 0}, {6.4f, 1.1f, 0.72f});     // table
  addBox(&soup, {7.2f, 1.0f, 0}, {7.8f, 2.2f, 1.4f});      // shelf
  return weldMesh(std::move(soup), 1e-6, "furnished rooms");
}

/// Upright prism with `sides` corners.
inline MeshModel column(int sides, float radius, float height) {
  MeshSoup soup;
  for (int i = 0; i < 2 * sides; ++i) {
    const double a = 2 * M_PI * (i % sides) / sides;
    soup.vertices.emplace_back(radius * std::cos(a), radius * std::sin(a), i < sides ? 0 : height);
  }
  const auto n = static_cast<uint32_t>(sides);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = (i + 1) % n;
    soup.triangles.push_back({i, j, n + j});
    soup.triangles.push_back({i, n + j, n + i});
    if (i > 0 && i + 1 < n) {
      soup.triangles.push_back({0, j, i});
      soup.triangles.push_back({n, n + i, n + j});
    }
  }
  soup.triangle_material.assign(soup.triangles.size(), 0);
  return weldMesh(std::move(soup), 1e-7, "column");
}

/// Pose of a camera that looks along `forward`. Its image is upright: the down axis of the image
/// points down as far as possible.
inline Pose lookAlong(const Eigen::Vector3d& position, const Eigen::Vector3d& forward) {
  Pose pose = Pose::Identity();
  const Eigen::Vector3d z = forward.normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  pose.linear().col(0) = x;
  pose.linear().col(1) = z.cross(x);
  pose.linear().col(2) = z;
  pose.translation() = position;
  return pose;
}

inline CameraModel pinhole(int width = 640, int height = 480, double focal = 500) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = focal;
  camera.fy = focal * 1.01;
  camera.cx = width / 2.0 - 0.5;
  camera.cy = height / 2.0 + 3.5;
  camera.validate("test camera");
  return camera;
}

/// Tries every triangle for every ray (Moeller-Trumbore). It is slow and plain on purpose.
class PlainRayCaster {
 public:
  PlainRayCaster(const MeshModel& mesh, const Pose& camera_pose) {
    const Pose to_camera = camera_pose.inverse();
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
      const Eigen::Vector3d e1 = mesh.vertices[t[1]].cast<double>() - a;
      const Eigen::Vector3d e2 = mesh.vertices[t[2]].cast<double>() - a;
      triangles_.push_back({to_camera * a, to_camera.linear() * e1, to_camera.linear() * e2});
    }
  }
  struct Hit {
    int face = -1;
    double depth = std::numeric_limits<double>::infinity();
  };
  /// Finds the first face on a ray from the camera centre. @param d direction, camera axes; the
  /// depth of the hit is in units of its length
  Hit cast(const Eigen::Vector3d& d) const {
    Hit hit;
    for (size_t i = 0; i < triangles_.size(); ++i) {
      const Triangle& t = triangles_[i];
      const Eigen::Vector3d p = d.cross(t.e2);
      const double det = t.e1.dot(p);
      if (std::abs(det) < 1e-12) continue;
      const Eigen::Vector3d q = -t.a;
      const double b1 = q.dot(p) / det;
      if (b1 < 0 || b1 > 1) continue;
      const Eigen::Vector3d r = q.cross(t.e1);
      const double b2 = d.dot(r) / det;
      if (b2 < 0 || b1 + b2 > 1) continue;
      const double depth = t.e2.dot(r) / det;
      if (depth > 0.01 && depth < hit.depth) hit = {static_cast<int>(i), depth};
    }
    return hit;
  }

 private:
  struct Triangle {
    Eigen::Vector3d a, e1, e2;
  };
  std::vector<Triangle> triangles_;
};

/// Ray through a pixel of an undistorted camera, with depth 1.
inline Eigen::Vector3d plainRay(const CameraModel& camera, double u, double v) {
  return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1};
}

/// Renders a picture with one grey value per face, without distortion.
inline cv::Mat render(const MeshModel& mesh, const CameraModel& camera, const Pose& pose,
                      int supersampling = 2) {
  const int s = supersampling;
  cv::Mat big(camera.height * s, camera.width * s, CV_8U, cv::Scalar(30));
  const Eigen::Vector3d light = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  std::vector<double> shades;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>();
    const Eigen::Vector3d n = (mesh.vertices[t[1]].cast<double>() - a)
                                  .cross(mesh.vertices[t[2]].cast<double>() - a)
                                  .normalized();
    shades.push_back(120 + 70 * n.dot(light) + 25 * n.x() + 15 * n.y());
  }
  const PlainRayCaster rays(mesh, pose);
  for (int y = 0; y < big.rows; ++y)
    for (int x = 0; x < big.cols; ++x) {
      const auto hit = rays.cast(plainRay(camera, (x + 0.5) / s - 0.5, (y + 0.5) / s - 0.5));
      if (hit.face >= 0) big.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(shades[hit.face]);
    }
  cv::Mat image;
  cv::resize(big, image, cv::Size(camera.width, camera.height), 0, 0, cv::INTER_AREA);
  return image;
}

/// Renders an exact depth image in metres, without distortion. 0: the ray meets no face.
inline cv::Mat renderDepth(const MeshModel& mesh, const CameraModel& camera, const Pose& pose) {
  cv::Mat depth(camera.height, camera.width, CV_32F, cv::Scalar(0));
  const PlainRayCaster rays(mesh, pose);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const auto hit = rays.cast(plainRay(camera, x, y));
      if (hit.face >= 0) depth.at<float>(y, x) = static_cast<float>(hit.depth);
    }
  return depth;
}

/// The camera with distortion coefficients for the given model.
inline CameraModel distorted(CameraModel camera, DistortionModel model) {
  camera.distortion = model;
  if (model == DistortionModel::kPlumbBob) camera.coefficients = {-0.28, 0.07, 2e-4, 2e-5, 0};
  if (model == DistortionModel::kRationalPolynomial)
    camera.coefficients = {0.2, -0.1, 1e-3, -5e-4, 0.01, 0.4, -0.05, 0.02};
  if (model == DistortionModel::kEquidistant) camera.coefficients = {0.02, -0.01, 0.003, -0.001};
  camera.validate("test");
  return camera;
}

}  // namespace edge_mcl::test
