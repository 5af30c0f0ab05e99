#include "edge_mcl/sim/renderer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/large_buffer.h"

namespace edge_mcl {

namespace {

constexpr int kTile = 4;  // side of a packet, pixels
static_assert(kTile * kTile == Scene::kPacket, "a tile is a packet");
constexpr uint16_t kNothing = 65535;

/// Surface that a pixel shows; outlines are where neighbouring pixels show different surfaces.
struct Surface {
  float depth;  // 0: the ray meets nothing
  uint32_t object, face;
};

/// Whether an outline runs between two neighbouring pixels.
inline bool differ(const Scene& scene, const Surface& a, const Surface& b) {
  if ((a.depth > 0) != (b.depth > 0)) return true;
  if ((a.object == b.object && a.face == b.face) || a.depth == 0) return false;
  if (a.object != b.object || scene.color(a.object, a.face) != scene.color(b.object, b.face))
    return true;
  if (scene.ownNormal(a.object, a.face).dot(scene.ownNormal(b.object, b.face)) < 0.999f)
    return true;  // the normals differ by more than 2.6 degrees
  return std::abs(a.depth - b.depth) > 0.1f * std::min(a.depth, b.depth);
}

cv::Vec3b toPixel(const Eigen::Vector3f& color) {
  const auto byte = [](float v) { return cv::saturate_cast<uint8_t>(255 * v); };
  return {byte(color.z()), byte(color.y()), byte(color.x())};
}

}  // namespace

Renderer::Renderer(const Scene& scene, const CameraModel& camera, Lighting lighting)
    : scene_(scene), rays_(camera), lighting_(std::move(lighting)) {
  if (lighting_.lamps.empty()) {
    const MeshModel& m = scene.building();
    Eigen::Vector3f lamp = 0.5f * (m.lowest + m.highest);
    lamp.z() = m.highest.z() - 0.3f;
    lighting_.lamps.push_back(lamp);
  }
  lamp_strength_ = 1.4f / std::sqrt(static_cast<float>(lighting_.lamps.size()));
}

Eigen::Vector3f Renderer::shade(const Eigen::Vector3f& eye, const Eigen::Vector3f& direction,
                                const SceneHit& hit) const {
  if (!hit.any()) return Eigen::Vector3f::Constant(0.05f);
  const Eigen::Vector3f point = eye + hit.distance * direction;
  // The ambient light depends on the face's direction, too, because faces see different parts of
  // the room.
  const Eigen::Vector3f& n = hit.normal;
  auto light =
      static_cast<float>(lighting_.ambient) * (1 + 0.18f * n.z() + 0.10f * n.x() - 0.06f * n.y());
  const float share = (1 - static_cast<float>(lighting_.ambient)) * lamp_strength_;
  for (const Eigen::Vector3f& lamp : lighting_.lamps) {
    const Eigen::Vector3f to_lamp = lamp - point;
    const float distance = to_lamp.norm();
    const float cosine = n.dot(to_lamp) / std::max(distance, 1e-3f);
    if (cosine <= 0) continue;
    if (lighting_.shadows && scene_.blocked(point + 1e-3f * n, lamp)) continue;
    constexpr float kReach = 4;  // metres at which a lamp has half its strength
    light += share * cosine / (1 + distance * distance / (kReach * kReach));
  }
  return light * hit.color;
}

RenderedImage Renderer::render(const Pose& T_map_camera) const {
  const int width = rays_.width(), height = rays_.height();
  RenderedImage out;
  out.color.create(height, width, CV_8UC3);
  out.depth.create(height, width, CV_32F);
  out.object.create(height, width, CV_16U);
  LargeBuffer<Surface> surface(static_cast<size_t>(width) * height);
  const Eigen::Matrix3f rotation = T_map_camera.linear().cast<float>();
  const Eigen::Vector3f eye = T_map_camera.translation().cast<float>();
  const auto direction = [&](const Eigen::Vector2f& ray) -> Eigen::Vector3f {
    return rotation * Eigen::Vector3f(ray.x(), ray.y(), 1);
  };

  const int tile_rows = (height + kTile - 1) / kTile, tile_columns = (width + kTile - 1) / kTile;
  tbb::parallel_for(0, tile_rows, [&](int tile_row) {
    for (int tile_column = 0; tile_column < tile_columns; ++tile_column) {
      Eigen::Vector3f directions[Scene::kPacket];
      SceneHit hits[Scene::kPacket];
      const auto pixelOf = [&](int i) {
        return cv::Point(tile_column * kTile + i % kTile, tile_row * kTile + i / kTile);
      };
      for (int i = 0; i < Scene::kPacket; ++i) {
        const cv::Point p = pixelOf(i);
        directions[i] = direction(rays_.at(std::min(p.x, width - 1), std::min(p.y, height - 1)));
      }
      scene_.cast(eye, directions, Scene::kPacket, hits);
      for (int i = 0; i < Scene::kPacket; ++i) {
        const cv::Point p = pixelOf(i);
        if (p.x >= width || p.y >= height) continue;
        const SceneHit& hit = hits[i];
        // The distance is the depth, because directions have length 1 along the optical axis.
        out.depth.at<float>(p) = hit.any() ? hit.distance : 0;
        out.object.at<uint16_t>(p) = hit.any() ? static_cast<uint16_t>(hit.object) : kNothing;
        out.color.at<cv::Vec3b>(p) = toPixel(shade(eye, directions[i], hit));
        surface[static_cast<size_t>(p.y) * width + p.x] = {hit.any() ? hit.distance : 0, hit.object,
                                                           hit.face};
      }
    }
  });

  // Outlines between a pixel and its right and lower neighbours. So every pair is compared once.
  constexpr uint8_t kRight = 1, kBelow = 2;
  LargeBuffer<uint8_t> outline(static_cast<size_t>(width) * height);
  tbb::parallel_for(0, height, [&](int y) {
    const Surface* row = &surface[static_cast<size_t>(y) * width];
    uint8_t* out_row = &outline[static_cast<size_t>(y) * width];
    for (int x = 0; x < width; ++x) {
      const bool right = x + 1 < width && differ(scene_, row[x], row[x + 1]);
      const bool below = y + 1 < height && differ(scene_, row[x], row[x + width]);
      out_row[x] = static_cast<uint8_t>((right ? kRight : 0) | (below ? kBelow : 0));
    }
  });

  tbb::parallel_for(0, height, [&](int y) {
    const uint8_t* here = &outline[static_cast<size_t>(y) * width];
    for (int x = 0; x < width; ++x) {
      if (!here[x] && !(x > 0 && here[x - 1] & kRight) && !(y > 0 && here[x - width] & kBelow))
        continue;
      Eigen::Vector3f directions[Scene::kPacket];
      SceneHit hits[Scene::kPacket];
      const auto offset = [](int k) { return (static_cast<float>(k) + 0.5f) / kTile - 0.5f; };
      const CameraRays::Slope slope = rays_.slopeAt(x, y);
      for (int i = 0; i < Scene::kPacket; ++i)
        directions[i] = direction(rays_.at(x, y) + offset(i % kTile) * slope.by_x +
                                  offset(i / kTile) * slope.by_y);
      scene_.cast(eye, directions, Scene::kPacket, hits);
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int i = 0; i < Scene::kPacket; ++i) sum += shade(eye, directions[i], hits[i]);
      out.color.at<cv::Vec3b>(y, x) = toPixel(sum / Scene::kPacket);
    }
  });
  return out;
}

}  // namespace edge_mcl
