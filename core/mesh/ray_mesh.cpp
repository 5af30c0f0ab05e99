#include "edge_mcl/core/mesh/ray_mesh.h"

#include <algorithm>
#include <limits>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/mesh/embree.h"

namespace edge_mcl {

namespace {

RTCRay rayOf(const Eigen::Vector3f& from, const Eigen::Vector3f& direction, float begin,
             float end) {
  RTCRay ray{};
  ray.org_x = from.x();
  ray.org_y = from.y();
  ray.org_z = from.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = begin;
  ray.tfar = end;
  ray.mask = ~0u;
  return ray;
}

}  // namespace

void attachMesh(RTCDeviceTy* device, RTCSceneTy* scene, const MeshModel& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertices.size()));
  auto* indices = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(uint32_t), mesh.triangles.size()));
  if (!vertices || !indices) {
    rtcReleaseGeometry(geometry);
    throw Error("out of memory in the ray caster");
  }
  for (size_t i = 0; i < mesh.vertices.size(); ++i)
    for (int k = 0; k < 3; ++k) vertices[3 * i + k] = mesh.vertices[i][k];
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) indices[3 * i + k] = mesh.triangles[i][k];
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

RayScene::RayScene(const MeshModel& mesh, Rays rays) : device_(rtcNewDevice(nullptr)) {
  if (!device_) throw Error("the ray caster cannot be started");
  scene_ = rtcNewScene(device_);
  if (rays == Rays::kRobust) rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  if (rays == Rays::kEvery)
    rtcSetSceneFlags(scene_,
                     static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | embree::kFilterFlag));
  try {
    attachMesh(device_, scene_, mesh);
  } catch (...) {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
    throw;
  }
  rtcCommitScene(scene_);
}

RayScene::~RayScene() {
  rtcReleaseScene(scene_);
  rtcReleaseDevice(device_);
}

std::optional<RayHit> firstHit(RTCSceneTy* scene, const Eigen::Vector3f& from,
                               const Eigen::Vector3f& direction, float begin, float end) {
  RTCRayHit ray{};
  ray.ray = rayOf(from, direction, begin, end);
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  embree::intersect1(scene, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return RayHit{ray.hit.primID, ray.ray.tfar, ray.hit.u, ray.hit.v};
}

void firstHits(RTCSceneTy* scene, const Eigen::Vector3f& from, const Eigen::Vector3f* directions,
               size_t count, float* along) {
  constexpr size_t kPacket = 16;
  for (size_t first = 0; first < count; first += kPacket) {
    RTCRayHit16 rays{};
    alignas(64) int valid[kPacket] = {};
    const size_t end = std::min(count, first + kPacket);
    for (size_t i = first; i < end; ++i) {
      const Eigen::Vector3f& direction = directions[i];
      const size_t k = i - first;
      if (!direction.allFinite()) continue;
      valid[k] = -1;
      rays.ray.org_x[k] = from.x();
      rays.ray.org_y[k] = from.y();
      rays.ray.org_z[k] = from.z();
      rays.ray.dir_x[k] = direction.x();
      rays.ray.dir_y[k] = direction.y();
      rays.ray.dir_z[k] = direction.z();
      rays.ray.tfar[k] = std::numeric_limits<float>::infinity();
      rays.ray.mask[k] = 0xffffffffu;
      rays.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    }
    embree::intersect16(valid, scene, &rays);
    for (size_t i = first; i < end; ++i) {
      const size_t k = i - first;
      const bool is_hit = valid[k] && rays.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
      along[i] = is_hit ? rays.ray.tfar[k] : std::numeric_limits<float>::infinity();
    }
  }
}

bool isBlocked(RTCSceneTy* scene, const Eigen::Vector3f& from, const Eigen::Vector3f& to,
               float margin, float end_margin) {
  RTCRay ray = rayOf(from, to - from, margin, 1 - end_margin);
  embree::occluded1(scene, &ray);
  return ray.tfar < 0;
}

}  // namespace edge_mcl
