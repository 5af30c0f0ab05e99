#include "edge_mcl/detector/training/training_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

namespace {

constexpr int kTile = 4;
constexpr int kPacket = kTile * kTile;
constexpr double kOversampling = 1.5;  // rays per pixel and axis

RTCGeometry instanceOf(RTCDevice device, RTCScene scene, const Eigen::Affine3f& pose) {
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, scene);
  rtcSetGeometryTimeStepCount(instance, 1);
  const Eigen::Matrix<float, 3, 4, Eigen::ColMajor> transform = pose.matrix().topRows<3>();
  rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform.data());
  rtcCommitGeometry(instance);
  return instance;
}

}  // namespace

TrainingView::TrainingView(const TrainingRoom& room, RTCDevice device)
    : room_(room), normals_(faceNormals(room.mesh)) {
  walls_ = makeScene(device, room.mesh, RTC_BUILD_QUALITY_LOW);
  top_ = rtcNewScene(device);
  const auto attach = [&](RTCScene scene, const Eigen::Affine3f& pose) {
    instances_.push_back(instanceOf(device, scene, pose));
    rtcAttachGeometryByID(top_, instances_.back(), static_cast<unsigned>(instances_.size() - 1));
  };
  attach(walls_, Eigen::Affine3f::Identity());
  for (const PlacedObject& placed : room.objects)
    attach(placed.object->scene, placed.T_room_object);
  rtcCommitScene(top_);
}

TrainingView::~TrainingView() {
  for (RTCGeometry instance : instances_) rtcReleaseGeometry(instance);
  rtcReleaseScene(top_);
  rtcReleaseScene(walls_);
}

bool TrainingView::blocked(const Eigen::Vector3f& from, const Eigen::Vector3f& to) const {
  return isBlocked(top_, from, to, 2e-3f, 5e-3f);
}

TrainingView::Camera TrainingView::randomCamera(TrainingRandom& random, int width) const {
  const auto number = [&](double low, double high) {
    return static_cast<float>(uniform(random, low, high));
  };
  Camera camera;
  const float half_angle = 0.5f * number(50, 95) * static_cast<float>(M_PI) / 180;
  const auto inside = [&](const Eigen::Vector3f& eye) {
    return std::any_of(room_.objects.begin(), room_.objects.end(), [&](const PlacedObject& p) {
      const Eigen::Vector3f q = p.T_room_object.inverse() * eye;
      return std::abs(q.x()) < 0.5f * p.object->size.x() + 0.3f &&
             std::abs(q.y()) < 0.5f * p.object->size.y() + 0.3f && q.z() > -0.3f &&
             q.z() < p.object->size.z() + 0.3f;
    });
  };
  camera.focal = 0.5f * static_cast<float>(width) / std::tan(half_angle);
  std::vector<const PlacedObject*> movable;
  for (const PlacedObject& p : room_.objects)
    if (p.object->label > 0) movable.push_back(&p);
  const PlacedObject* aim = nullptr;
  if (!movable.empty() && chance(random, 0.8))
    aim = movable[static_cast<size_t>(choose(random, static_cast<int>(movable.size())))];
  const float nearest = number(0.9, 2.5), farthest = nearest + number(0.5, 2.5);
  for (int attempt = 0; attempt < 40; ++attempt) {
    camera.eye = {number(0.25, room_.size.x() - 0.25), number(0.25, room_.size.y() - 0.25),
                  number(0.4, std::min(2.6f, room_.size.z() - 0.25f))};
    if (inside(camera.eye)) continue;
    // An object between the camera and its aim would fill the image.
    if (aim) {
      const Eigen::Vector3f middle =
          aim->T_room_object * Eigen::Vector3f(0, 0, 0.6f * aim->object->size.z());
      if (blocked(camera.eye, camera.eye + 0.6f * (middle - camera.eye))) continue;
    }
    const float distance = aim ? (aim->T_room_object.translation() - camera.eye).norm() : nearest;
    if (distance >= nearest && distance <= farthest) break;
  }
  Eigen::Vector3f target(number(0, room_.size.x()), number(0, room_.size.y()), number(0.2, 1.8));
  if (aim) {
    target = aim->T_room_object * Eigen::Vector3f(0, 0, aim->object->size.z() * number(0.1, 0.9));
    target += 0.4f * Eigen::Vector3f(number(-1, 1), number(-1, 1), number(-1, 1));
  }
  Eigen::Vector3f forward = target - camera.eye;
  forward.z() = std::max(-1.2f * forward.head<2>().norm(), forward.z());
  if (forward.norm() < 0.1f) forward = Eigen::Vector3f::UnitX();
  forward.normalize();
  const Eigen::Vector3f right = forward.cross(Eigen::Vector3f::UnitZ()).normalized();
  camera.rotation << right, forward.cross(right), forward;  // x right, y down, z forward
  camera.rotation *=
      Eigen::AngleAxisf(number(-0.12, 0.12), Eigen::Vector3f::UnitZ()).toRotationMatrix();
  return camera;
}

Eigen::Vector3f TrainingView::shade(const Eigen::Vector3f& eye, const Eigen::Vector3f& direction,
                                    float distance, unsigned part, unsigned face,
                                    uint8_t* label) const {
  const Eigen::Vector3f point = eye + distance * direction;
  Eigen::Vector3f local = point, own_normal, normal;
  const SurfacePattern* pattern = nullptr;
  if (part == 0) {
    own_normal = normal = normals_[face];
    pattern = &room_.patterns[room_.mesh.triangle_material[face]];
    *label = 0;
  } else {
    const PlacedObject& placed = room_.objects[part - 1];
    local = placed.T_room_object.inverse() * point;
    own_normal = placed.object->normals[face];
    normal = (placed.T_room_object.linear() * own_normal).normalized();
    pattern = &placed.patterns[placed.object->mesh.triangle_material[face]];
    *label = static_cast<uint8_t>(placed.object->label);
  }
  if (normal.dot(direction) > 0) normal = -normal;
  float light = room_.ambient * (1 + 0.18f * normal.z() + 0.10f * normal.x() - 0.06f * normal.y());
  float mirrored = 0;
  const float share =
      1.4f * (1 - room_.ambient) / std::sqrt(static_cast<float>(room_.lamps.size()));
  for (const Eigen::Vector3f& lamp : room_.lamps) {
    const Eigen::Vector3f to_lamp = lamp - point;
    const float length = std::max(to_lamp.norm(), 1e-3f), cosine = normal.dot(to_lamp) / length;
    if (cosine <= 0) continue;
    if (room_.shadows && blocked(point + 2e-3f * normal, lamp)) continue;
    constexpr float kReach = 4;  // metres at which a lamp has half its strength
    light += share * cosine / (1 + length * length / (kReach * kReach));
    if (pattern->shine > 0) {
      const Eigen::Vector3f half = (to_lamp / length - direction.normalized()).normalized();
      mirrored += pattern->shine * std::pow(std::max(0.0f, normal.dot(half)), 30.0f);
    }
  }
  return light * pattern->at(local, own_normal) + Eigen::Vector3f::Constant(mirrored);
}

void TrainingView::sampleTile(const Camera& camera, const cv::Size& size, const cv::Point& corner,
                              Sample* samples) const {
  RTCRayHit16 rays{};
  alignas(64) int valid[kPacket];
  Eigen::Vector3f directions[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const cv::Point p = corner + cv::Point(i % kTile, i / kTile);
    directions[i] =
        camera.rotation *
        Eigen::Vector3f(
            (static_cast<float>(p.x) + 0.5f - 0.5f * static_cast<float>(size.width)) / camera.focal,
            (static_cast<float>(p.y) + 0.5f - 0.5f * static_cast<float>(size.height)) /
                camera.focal,
            1);
    valid[i] = -1;
    rays.ray.org_x[i] = camera.eye.x();
    rays.ray.org_y[i] = camera.eye.y();
    rays.ray.org_z[i] = camera.eye.z();
    rays.ray.dir_x[i] = directions[i].x();
    rays.ray.dir_y[i] = directions[i].y();
    rays.ray.dir_z[i] = directions[i].z();
    rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
    rays.ray.mask[i] = 0xffffffffu;
    rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  embree::intersect16(valid, top_, &rays);
  for (int i = 0; i < kPacket; ++i) {
    samples[i] = {Eigen::Vector3f::Zero(), 0};
    if (rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    samples[i].color = shade(camera.eye, directions[i], rays.ray.tfar[i], rays.hit.instID[0][i],
                             rays.hit.primID[i], &samples[i].label);
  }
}

TrainingImage TrainingView::take(TrainingRandom& random, int width, int height) const {
  const cv::Size size(cvRound(kOversampling * width), cvRound(kOversampling * height));
  const Camera camera = randomCamera(random, size.width);
  cv::Mat color(size, CV_8UC3), label(size, CV_8U);
  for (int y = 0; y < size.height; y += kTile)
    for (int x = 0; x < size.width; x += kTile) {
      Sample samples[kPacket];
      sampleTile(camera, size, {x, y}, samples);
      for (int i = 0; i < kPacket; ++i) {
        const cv::Point p(x + i % kTile, y + i / kTile);
        if (p.x >= size.width || p.y >= size.height) continue;
        const Eigen::Vector3f c = 255 * samples[i].color;
        color.at<cv::Vec3b>(p) = {cv::saturate_cast<uint8_t>(c.z()),
                                  cv::saturate_cast<uint8_t>(c.y()),
                                  cv::saturate_cast<uint8_t>(c.x())};
        label.at<uint8_t>(p) = samples[i].label;
      }
    }
  TrainingImage image;
  cv::resize(color, image.color, {width, height}, 0, 0, cv::INTER_AREA);
  cv::resize(label, image.label, {width, height}, 0, 0, cv::INTER_NEAREST);
  return image;
}

}  // namespace edge_mcl
