#include "edge_mcl/core/edges/covered_edges.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "edge_mcl/core/mesh/embree.h"
#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

namespace {

using Eigen::Vector3d;

/// Unit normal of a triangle by its winding.
Vector3d normalOf(const MeshModel& mesh, uint32_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Vector3d a = mesh.vertices[t[0]].cast<double>();
  return (mesh.vertices[t[1]].cast<double>() - a)
      .cross(mesh.vertices[t[2]].cast<double>() - a)
      .normalized();
}

struct Hit {
  uint32_t triangle = 0;
  Vector3d normal;
};

RTCRay rayOf(const Vector3d& from, const Vector3d& direction, double far) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(from.x());
  ray.org_y = static_cast<float>(from.y());
  ray.org_z = static_cast<float>(from.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tfar = static_cast<float>(far);
  ray.mask = ~0u;
  return ray;
}

/// A query that notes whether a ray meets a face that looks against `normal`.
struct FacingQuery {
  embree::QueryContext context;  // the first member, so that the filter finds the others
  const MeshModel* mesh;
  Vector3d normal;
  double parallel;
  bool found;

  static void filter(const RTCFilterFunctionNArguments* arguments) {
    auto* query = reinterpret_cast<FacingQuery*>(arguments->context);
    const uint32_t triangle = RTCHitN_primID(arguments->hit, arguments->N, 0);
    if (normalOf(*query->mesh, triangle).dot(query->normal) < -query->parallel) query->found = true;
    arguments->valid[0] = 0;  // go on to the next hit
  }
};

class Cover {
 public:
  Cover(const MeshModel& mesh, bool material_borders)
      : mesh_(mesh),
        material_borders_(material_borders),
        scene_(mesh, RayScene::Rays::kEvery),
        near_(std::min(kNear, kNear * mesh.diagonal())) {}

  /// Whether an edge can be seen at a point of it.
  /// @param is_shared whether three or more faces meet at the edge.
  bool isVisible(const EdgeLine& edge, bool is_shared, const Vector3d& point) const {
    if (edge.kind == EdgeKind::kBoundary) {
      const Vector3d into = edge.into_a.cast<double>();
      const Vector3d normal = edge.tangent().cast<double>().cross(into).normalized();
      return isOpen(point, into, normal, false) || isOpen(point, into, -normal, false);
    }
    // The normals tell which side of a face is its front. The back is the inside of a body.
    return isOpen(point, edge.into_a.cast<double>(), edge.normal_a.cast<double>(), is_shared) ||
           isOpen(point, edge.into_b.cast<double>(), edge.normal_b.cast<double>(), is_shared);
  }

 private:
  /// Faces this near to each other are one, m. Programs round coordinates to 1 mm or finer. For a
  /// model that is smaller than 1 m it is a thousandth of its size.
  static constexpr double kNear = 1e-3;
  /// Cosine of the largest angle between parallel faces, 2.6 degrees.
  static constexpr double kParallel = 0.999;

  std::optional<Hit> firstFace(const Vector3d& from, const Vector3d& direction, double far) const {
    const std::optional<RayHit> hit = firstHit(scene_.get(), from.cast<float>(),
                                               direction.cast<float>(), 0, static_cast<float>(far));
    if (!hit) return std::nullopt;
    return Hit{hit->triangle, normalOf(mesh_, hit->triangle)};
  }

  /// The face of the plane through `point` that is seen from the side of `normal`.
  std::optional<Hit> faceOf(const Vector3d& point, const Vector3d& normal) const {
    std::optional<Hit> hit = firstFace(point + near_ * normal, -normal, 2 * near_);
    if (!hit || std::abs(hit->normal.dot(normal)) < kParallel) return std::nullopt;
    return hit;
  }

  /// Whether an edge can be seen from the side of `normal` of one of its faces.
  /// @param into unit vector from the edge into the face.
  bool isOpen(const Vector3d& edge, const Vector3d& into, const Vector3d& normal,
              bool is_shared) const {
    const Vector3d on_face = edge + 3 * near_ * into;
    const std::optional<Hit> beyond = faceOf(edge - 3 * near_ * into, normal);
    if (beyond) {
      const std::optional<Hit> own = faceOf(on_face, normal);
      // Without the own face something else is nearer, and the edge is not seen from here.
      const bool same_material =
          !material_borders_ || !own ||
          mesh_.triangle_material[own->triangle] == mesh_.triangle_material[beyond->triangle];
      if (same_material) return false;
    }
    return !isBuried(on_face, normal, is_shared);
  }

  /// Whether the front of a face is inside another body: a face of that body touches it, and the
  /// way on leads to the back of a face. Back-to-back walls of two rooms touch each other, too, but
  /// the way leads to the front of the next wall. Where both bodies have the same face, welding has
  /// left one of the two. Its edges are shared, and both ways lead to backs.
  bool isBuried(const Vector3d& on_face, const Vector3d& normal, bool is_shared) const {
    if (!leadsToBack(on_face, normal)) return false;
    return touchesOther(on_face, normal) || (is_shared && leadsToBack(on_face, -normal));
  }
  bool leadsToBack(const Vector3d& on_face, const Vector3d& direction) const {
    const std::optional<Hit> next = firstFace(on_face + near_ * direction, direction, INFINITY);
    return next && next->normal.dot(direction) > 0;
  }
  /// Whether a face that looks the other way lies on a face. The two may have the same distance
  /// from everywhere, so every hit of the ray counts.
  bool touchesOther(const Vector3d& on_face, const Vector3d& normal) const {
    FacingQuery query{{}, &mesh_, normal, kParallel, false};
    RTCRay ray = rayOf(on_face + near_ * normal, -normal, 2 * near_);
    embree::occluded1(scene_.get(), &ray, &query.context, &FacingQuery::filter);
    return query.found;
  }

  const MeshModel& mesh_;
  bool material_borders_;
  RayScene scene_;
  double near_;
};

/// Appends the visible pieces of an edge.
void appendVisible(const Cover& cover, const EdgeLine& edge, bool is_shared,
                   std::vector<EdgeLine>* pieces) {
  // A pane or panel is wider than this. The ends of pieces are found by bisection.
  constexpr double kStep = 0.03;
  constexpr int kFewest = 2, kMost = 500, kBisections = 12;
  const double length = edge.length();
  const int count = std::clamp(static_cast<int>(std::ceil(length / kStep)), kFewest, kMost);
  const auto at = [&](double share) {
    return Vector3d(edge.start.cast<double>() + share * (edge.end - edge.start).cast<double>());
  };
  const auto isVisible = [&](double share) { return cover.isVisible(edge, is_shared, at(share)); };
  double begin = 0, last = 0;
  bool was_visible = false;
  const auto append = [&](double from, double to) {
    EdgeLine piece = edge;
    if (from > 0) piece.start = at(from).cast<float>();
    if (to < 1) piece.end = at(to).cast<float>();
    if (piece.length() > 0) pieces->push_back(piece);
  };
  for (int i = 0; i < count; ++i) {
    const double share = (i + 0.5) / count;
    const bool visible = isVisible(share);
    if (i == 0) {
      begin = 0;
    } else if (visible != was_visible) {
      double low = last, high = share;
      for (int k = 0; k < kBisections; ++k) {
        const double middle = (low + high) / 2;
        (isVisible(middle) == was_visible ? low : high) = middle;
      }
      if (was_visible) append(begin, low);
      begin = high;
    }
    was_visible = visible;
    last = share;
  }
  if (was_visible) append(begin, 1);
}

/// The mesh without faces that only hide: they are no bodies, so they have no inside, and an edge
/// beside them can be seen once the thing has gone. @return none when it has no such faces
std::optional<MeshModel> withoutHidingFaces(const MeshModel& mesh) {
  if (mesh.hides_only.empty()) return std::nullopt;
  MeshModel solid = mesh;
  solid.triangles.clear();
  solid.triangle_material.clear();
  solid.hides_only.clear();
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.hides_only[i]) continue;
    solid.triangles.push_back(mesh.triangles[i]);
    solid.triangle_material.push_back(mesh.triangle_material[i]);
  }
  return solid;
}

}  // namespace

CoveredEdges dropCoveredEdges(const MeshModel& mesh, bool material_borders,
                              const std::vector<bool>& is_shared, std::vector<EdgeLine>* edges) {
  CoveredEdges dropped;
  if (mesh.triangles.empty() || edges->empty()) return dropped;
  const std::optional<MeshModel> solid = withoutHidingFaces(mesh);
  const Cover cover(solid ? *solid : mesh, material_borders);
  std::vector<std::vector<EdgeLine>> pieces(edges->size());
  tbb::parallel_for(size_t{0}, edges->size(), [&](size_t i) {
    const EdgeLine& edge = (*edges)[i];
    const bool is_surface_edge = edge.kind == EdgeKind::kBoundary || edge.kind == EdgeKind::kCrease;
    if (is_surface_edge && edge.length() > 0)
      appendVisible(cover, edge, is_shared[i], &pieces[i]);
    else
      pieces[i] = {edge};
  });
  std::vector<EdgeLine> kept;
  kept.reserve(edges->size());
  for (size_t i = 0; i < pieces.size(); ++i) {
    double length = 0;
    for (const EdgeLine& piece : pieces[i]) length += static_cast<double>(piece.length());
    if (pieces[i].empty()) ++dropped.count;
    dropped.length += std::max(0.0, static_cast<double>((*edges)[i].length()) - length);
    kept.insert(kept.end(), pieces[i].begin(), pieces[i].end());
  }
  *edges = std::move(kept);
  return dropped;
}

}  // namespace edge_mcl
