#include "edge_mcl/sim/scene.h"

#include <cmath>
#include <limits>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/mesh/embree.h"
#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

namespace {

/// Distance of a point to a triangle (C. Ericson, "Real-Time Collision Detection", 5.1.5).
double distanceToTriangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, n = ab.cross(ac);
  const double area2 = n.squaredNorm();
  if (area2 > 0) {
    const double u = n.dot(ab.cross(p - a)) / area2, v = n.dot((p - a).cross(ac)) / area2;
    // Barycentric coordinates: u is the weight of c, v the weight of b.
    if (u >= 0 && v >= 0 && u + v <= 1) return std::abs(n.dot(p - a)) / std::sqrt(area2);
  }
  const auto toSegment = [&](const Eigen::Vector3d& s, const Eigen::Vector3d& e) {
    const Eigen::Vector3d d = e - s;
    const double t =
        std::max(0.0, std::min(1.0, (p - s).dot(d) / std::max(d.squaredNorm(), 1e-30)));
    return (p - s - t * d).norm();
  };
  return std::min({toSegment(a, b), toSegment(b, c), toSegment(c, a)});
}

}  // namespace

struct Scene::Impl {
  struct Part {
    MeshModel mesh;
    RTCScene scene = nullptr;
    RTCGeometry instance = nullptr;
    std::vector<Eigen::Vector3f> own_normals;  // of the faces, in the axes of the mesh
    struct Face {
      Eigen::Vector3f normal, color;  // map axes
    };
    std::vector<Face> faces;  // in the present pose of the part
  };
  RTCDevice device = nullptr;
  RTCScene top = nullptr;   // holds only instances, so that moving one is cheap
  std::vector<Part> parts;  // first the building, then the objects

  ~Impl() {
    for (Part& part : parts) {
      if (part.instance) rtcReleaseGeometry(part.instance);
      if (part.scene) rtcReleaseScene(part.scene);
    }
    if (top) rtcReleaseScene(top);
    if (device) rtcReleaseDevice(device);
  }

  void add(MeshModel mesh) {
    const auto number = static_cast<unsigned>(parts.size());
    parts.emplace_back();
    Part& part = parts.back();
    part.mesh = std::move(mesh);
    for (const auto& t : part.mesh.triangles) {
      const auto corner = [&](int k) { return part.mesh.vertices[t[k]].cast<double>().eval(); };
      part.own_normals.push_back(
          (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized().cast<float>());
    }
    for (const uint32_t material : part.mesh.triangle_material)
      part.faces.push_back({Eigen::Vector3f::Zero(), part.mesh.material_colors[material]});
    part.scene = rtcNewScene(device);
    rtcSetSceneFlags(part.scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(part.scene, RTC_BUILD_QUALITY_HIGH);
    attachMesh(device, part.scene, part.mesh);
    rtcCommitScene(part.scene);
    part.instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(part.instance, part.scene);
    rtcSetGeometryTimeStepCount(part.instance, 1);
    place(number, Pose::Identity());
    rtcAttachGeometryByID(top, part.instance, number);
    rtcCommitScene(top);
  }

  void place(size_t number, const Pose& pose) {
    Part& part = parts.at(number);
    const Eigen::Matrix3f rotation = pose.linear().cast<float>();
    for (size_t i = 0; i < part.faces.size(); ++i)
      part.faces[i].normal = rotation * part.own_normals[i];
    const Eigen::Matrix<float, 3, 4, Eigen::ColMajor> transform =
        pose.matrix().topRows<3>().cast<float>();
    rtcSetGeometryTransform(part.instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform.data());
    rtcCommitGeometry(part.instance);
  }
};

Scene::Scene(MeshModel building) : impl_(std::make_unique<Impl>()) {
  Impl& m = *impl_;
  if (building.triangles.empty())
    throw InputError("simulator: the model has no faces, so there is nothing to see");
  m.device = rtcNewDevice(nullptr);
  if (!m.device) throw Error("simulator: the ray caster cannot be started");
  m.top = rtcNewScene(m.device);
  rtcSetSceneFlags(m.top,
                   static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC));
  m.add(std::move(building));
}

Scene::~Scene() = default;

size_t Scene::addObject(MeshModel mesh) {
  impl_->add(std::move(mesh));
  return objectCount() - 1;
}

size_t Scene::objectCount() const { return impl_->parts.size() - 1; }

void Scene::place(size_t object, const Pose& T_map_object) {
  impl_->place(object + 1, T_map_object);
}

void Scene::commit() { rtcCommitScene(impl_->top); }

void Scene::cast(const Eigen::Vector3f& origin, const Eigen::Vector3f* directions, int count,
                 SceneHit* hits) const {
  RTCRayHit16 rays{};
  alignas(64) int valid[kPacket] = {};
  for (int i = 0; i < count; ++i) {
    hits[i].distance = std::numeric_limits<float>::infinity();
    if (!directions[i].allFinite()) continue;
    valid[i] = -1;
    rays.ray.org_x[i] = origin.x();
    rays.ray.org_y[i] = origin.y();
    rays.ray.org_z[i] = origin.z();
    rays.ray.dir_x[i] = directions[i].x();
    rays.ray.dir_y[i] = directions[i].y();
    rays.ray.dir_z[i] = directions[i].z();
    rays.ray.tnear[i] = 0;
    rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
    rays.ray.mask[i] = 0xffffffffu;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  embree::intersect16(valid, impl_->top, &rays);
  for (int i = 0; i < count; ++i) {
    if (!valid[i] || rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    SceneHit& hit = hits[i];
    hit.distance = rays.ray.tfar[i];
    hit.object = rays.hit.instID[0][i];
    hit.face = rays.hit.primID[i];
    const Impl::Part::Face& face = impl_->parts[hit.object].faces[hit.face];
    hit.normal = face.normal;
    if (hit.normal.dot(directions[i]) > 0) hit.normal = -hit.normal;
    hit.color = face.color;
  }
}

bool Scene::blocked(const Eigen::Vector3f& from, const Eigen::Vector3f& to) const {
  return isBlocked(impl_->top, from, to, 1e-3f, 1e-3f);
}

double Scene::clearance(const Eigen::Vector3d& point, double farthest) const {
  const MeshModel& mesh = building();
  double nearest = farthest;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int k) { return mesh.vertices[t[k]].cast<double>().eval(); };
    const Eigen::Vector3d a = corner(0), b = corner(1), c = corner(2);
    const Eigen::Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
    if (((low - point).array() > nearest).any() || ((point - high).array() > nearest).any())
      continue;
    nearest = std::min(nearest, distanceToTriangle(point, a, b, c));
  }
  return nearest;
}

const Eigen::Vector3f& Scene::ownNormal(uint32_t object, uint32_t face) const {
  return impl_->parts[object].own_normals[face];
}

const Eigen::Vector3f& Scene::color(uint32_t object, uint32_t face) const {
  return impl_->parts[object].faces[face].color;
}

const MeshModel& Scene::building() const { return impl_->parts.front().mesh; }

}  // namespace edge_mcl
