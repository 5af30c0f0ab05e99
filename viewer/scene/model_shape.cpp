#include "edge_mcl/viewer/scene/model_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace edge_mcl {

namespace {

/// Shades a colour with light from above and from the side. Both sides of a face look alike,
/// because the winding of meshes is not reliable.
Eigen::Vector3f shaded(const Eigen::Vector3f& color, const Eigen::Vector3f& normal) {
  const Eigen::Vector3f light = Eigen::Vector3f(0.35F, 0.5F, 0.8F).normalized();
  const float brightness = 0.72F + 0.28F * std::abs(normal.dot(light));
  // The model is pale, so that particles and paths in it stand out.
  const Eigen::Vector3f pale = 0.4F * color + Eigen::Vector3f::Constant(0.6F);
  return brightness * pale;
}

/// Cuts a triangle at a height and keeps the lower part: a polygon of up to four corners
/// (Sutherland and Hodgman). @return number of corners.
size_t clipBelow(const std::array<Eigen::Vector3f, 3>& in, float height,
                 std::array<Eigen::Vector3f, 4>* out) {
  size_t count = 0;
  for (size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3f& a = in[k];
    const Eigen::Vector3f& b = in[(k + 1) % 3];
    const bool a_below = a.z() <= height, b_below = b.z() <= height;
    if (a_below) (*out)[count++] = a;
    if (a_below != b_below) (*out)[count++] = a + (height - a.z()) / (b.z() - a.z()) * (b - a);
  }
  return count;
}

}  // namespace

ModelShape shapeBelow(const MeshModel& mesh, const EdgeModel& edges, float height) {
  ModelShape shape;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Eigen::Vector3f, 3> corners;
    for (size_t k = 0; k < 3; ++k) corners[k] = mesh.vertices[mesh.triangles[t][k]];
    const Eigen::Vector3f normal =
        (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    const size_t material = t < mesh.triangle_material.size() ? mesh.triangle_material[t] : 0;
    const Eigen::Vector3f color = material < mesh.material_colors.size()
                                      ? mesh.material_colors[material]
                                      : Eigen::Vector3f::Constant(0.7F);
    std::array<Eigen::Vector3f, 4> polygon;
    const size_t count = clipBelow(corners, height, &polygon);
    for (size_t k = 2; k < count; ++k)
      shape.triangles.push_back({{polygon[0], polygon[k - 1], polygon[k]}, shaded(color, normal)});
  }
  for (const EdgeLine& line : edges.lines) {
    if (line.kind == EdgeKind::kContour) continue;
    Eigen::Vector3f low = line.start, high = line.end;
    if (low.z() > high.z()) std::swap(low, high);
    if (low.z() > height) continue;
    if (high.z() > height) high = low + (height - low.z()) / (high.z() - low.z()) * (high - low);
    shape.lines.push_back({low, high});
  }
  return shape;
}

bool firstHit(const ModelShape& shape, const Eigen::Vector3f& origin,
              const Eigen::Vector3f& direction, Eigen::Vector3f* hit) {
  // T. Moeller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
  float nearest = std::numeric_limits<float>::infinity();
  for (const ModelShape::Triangle& t : shape.triangles) {
    const Eigen::Vector3f ab = t.corners[1] - t.corners[0], ac = t.corners[2] - t.corners[0];
    const Eigen::Vector3f p = direction.cross(ac);
    const float determinant = ab.dot(p);
    if (std::abs(determinant) < 1e-12F) continue;
    const Eigen::Vector3f to_origin = origin - t.corners[0];
    const float u = to_origin.dot(p) / determinant;
    const Eigen::Vector3f q = to_origin.cross(ab);
    const float v = direction.dot(q) / determinant;
    const float along = ac.dot(q) / determinant;
    if (u < 0 || v < 0 || u + v > 1 || along <= 0) continue;
    nearest = std::min(nearest, along);
  }
  if (!std::isfinite(nearest)) return false;
  *hit = origin + nearest * direction;
  return true;
}

}  // namespace edge_mcl
