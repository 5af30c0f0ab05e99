#include "edge_mcl/core/mesh/closest_point.h"

#include "edge_mcl/core/mesh/embree.h"

namespace edge_mcl {

Eigen::Vector3d closestPointOnTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                       const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap), d3 = ab.dot(bp), d4 = ac.dot(bp), d5 = ab.dot(cp),
               d6 = ac.dot(cp);
  if (d1 <= 0 && d2 <= 0) return a;
  if (d3 >= 0 && d4 <= d3) return b;
  if (d6 >= 0 && d5 <= d6) return c;
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  return a + (vb * ab + vc * ac) / (va + vb + vc);
}

ClosestFace::ClosestFace(const MeshModel& mesh)
    : mesh_(mesh), scene_(std::make_unique<RayScene>(mesh)) {}
ClosestFace::~ClosestFace() = default;

ClosestFace::Hit ClosestFace::find(const Eigen::Vector3d& point, double reach) const {
  struct Query {
    const MeshModel* mesh;
    Eigen::Vector3d point;
    Hit hit;
  } query{&mesh_, point, {}};
  query.hit.distance = reach;
  RTCPointQuery sphere{};
  sphere.x = static_cast<float>(point.x());
  sphere.y = static_cast<float>(point.y());
  sphere.z = static_cast<float>(point.z());
  sphere.radius = static_cast<float>(reach);
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const auto look = [](RTCPointQueryFunctionArguments* arguments) {
    auto* q = static_cast<Query*>(arguments->userPtr);
    const auto& corners = q->mesh->triangles[arguments->primID];
    Eigen::Vector3d v[3];
    for (int i = 0; i < 3; ++i) v[i] = q->mesh->vertices[corners[i]].cast<double>();
    const Eigen::Vector3d closest = closestPointOnTriangle(q->point, v[0], v[1], v[2]);
    const double distance = (closest - q->point).norm();
    if (distance > q->hit.distance) return false;
    // Of several faces at the same distance the first one counts, because the order of visits must
    // not matter.
    if (q->hit.found && distance == q->hit.distance && q->hit.face < arguments->primID)
      return false;
    q->hit = {true, arguments->primID, closest, distance};
    arguments->query->radius = static_cast<float>(distance * (1 + 1e-6) + 1e-7);
    return true;
  };
  rtcPointQuery(scene_->get(), &sphere, &context, look, &query);
  return query.hit;
}

}  // namespace edge_mcl
