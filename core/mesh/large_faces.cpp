#include "edge_mcl/core/mesh/large_faces.h"

#include <cmath>

namespace edge_mcl {

namespace {

using Corner = Eigen::Vector3d;

/// Smaller faces hide less than a piece of furniture takes up in the tree, m^2.
constexpr double kSmallest = 0.5;

/// Whether a face hides a box. @param box centre, from the eye
bool hides(const Rectangle& face, const Corner& eye, const Corner& box, const Corner& sides,
           double margin) {
  // Behind the plane of the face.
  Corner normal = (face[1] - face[0]).cross(face[2] - face[0]).normalized();
  double to_plane = normal.dot(face[0] - eye);
  if (to_plane < 0) {
    normal = -normal;
    to_plane = -to_plane;
  }
  if (normal.dot(box) - normal.cwiseAbs().dot(sides) - to_plane <= margin + 2 * kFlat) return false;
  // Within the pyramid from the eye through the corners. The limit keeps clear of rays so close to
  // an edge that rounding decides, or how flat the face is.
  constexpr double kClear = 1e-5;  // radians
  Corner inside = Corner::Zero();
  for (const Corner& corner : face) inside += corner - eye;
  const double farthest = box.norm() + sides.norm();
  for (size_t k = 0; k < face.size(); ++k) {
    Corner side = (face[k] - eye).cross(face[(k + 1) % face.size()] - eye);
    if (side.dot(inside) < 0) side = -side;
    const double length = (face[(k + 1) % face.size()] - face[k]).norm();
    const double clear = (kClear * side.norm() + 2 * kFlat * length) * farthest;
    if (side.dot(box) - side.cwiseAbs().dot(sides) <= clear) return false;
  }
  return true;
}

}  // namespace

LargeFaces::LargeFaces(const MeshModel& mesh) : faces_(flatRectangles(mesh, kSmallest)) {
  if (faces_.empty()) return;
  MeshModel halves;  // two triangles of every face
  for (const Rectangle& face : faces_) {
    const auto first = static_cast<uint32_t>(halves.vertices.size());
    for (const Corner& corner : face) halves.vertices.push_back(corner.cast<float>());
    halves.triangles.push_back({first, first + 1, first + 2});
    halves.triangles.push_back({first, first + 2, first + 3});
  }
  scene_ = std::make_unique<RayScene>(halves);
}

bool LargeFaces::hide(const Eigen::Vector3f& eye, const Eigen::Vector3f& centre,
                      const Eigen::Vector3f& half, float margin) const {
  if (!scene_ || ((eye - centre).cwiseAbs() - half).maxCoeff() <= 0) return false;
  const Eigen::Vector3f direction = centre - eye;
  const Corner from = eye.cast<double>(), box = centre.cast<double>() - from;
  const Corner sides = half.cast<double>();
  float begin = 0;
  // A table in front of a wall is asked first. Behind some walls there is little left to find.
  constexpr int kMostFaces = 6;
  for (int k = 0; k < kMostFaces; ++k) {
    const std::optional<RayHit> hit = firstHit(scene_->get(), eye, direction, begin, 1);
    if (!hit) return false;
    if (hides(faces_[hit->triangle / 2], from, box, sides, margin)) return true;
    begin = hit->along * 1.0001f + 1e-6f;
  }
  return false;
}

}  // namespace edge_mcl
